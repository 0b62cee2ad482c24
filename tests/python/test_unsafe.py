"""Unsafe code is counted and justified in SECURITY.md, and occurs nowhere else."""

import re
import tomllib
from pathlib import Path

from conftest import ROOT

# Tests, examples and developer tools.
ELSEWHERE = {"xtask", "fmu/tests/clumsy", "examples/depth_hold"}
MEMBERS = tomllib.loads(Path(ROOT, "Cargo.toml").read_text())["workspace"]["members"]
CRATES = [Path(member, "src") for member in MEMBERS if member not in ELSEWHERE]
# Comments, and strings on a single line.
IGNORED = re.compile(r'//[^\n]*|"(?:[^"\\\n]|\\.)*"')


def uses(text):
    """How often the keyword occurs in the code."""
    return len(re.findall(r"\bunsafe\b", IGNORED.sub("", text)))


def found():
    """Files of the crates with unsafe code, and how much."""
    files = [path for crate in CRATES for path in sorted((ROOT / crate).rglob("*.rs")) if path.name != "tests.rs"]
    counts = {path.relative_to(ROOT).as_posix(): uses(path.read_text()) for path in files}
    return {name: count for name, count in counts.items() if count}


def rows(text):
    """The contents of the table: path, or folder with `/`, and count."""
    return {path: int(count) for path, count in re.findall(r"^\| `([\w/.]+)` \| (\d+) \|", text, re.MULTILINE)}


def test_the_table_of_unsafe_code_is_complete():
    said = rows(Path(ROOT, "SECURITY.md").read_text())
    counted = dict.fromkeys(said, 0)
    unknown = []
    for name, count in found().items():
        places = [place for place in said if name == place or (place.endswith("/") and name.startswith(place))]
        if places:
            counted[max(places, key=len)] += count
        else:
            unknown.append(f"{name}: {count}")
    assert not unknown, "SECURITY.md does not justify the unsafe code in\n" + "\n".join(unknown)
    assert said == counted, f"SECURITY.md says {said}, but there is {counted}"


def test_comments_and_texts_are_no_code():
    assert uses('// unsafe\nlet a = "unsafe"; unsafe { f() }\nunsafe fn g() {}') == 2
