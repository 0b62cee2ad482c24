"""Everything that runs elsewhere, and that documents tell readers to run, exists here."""

import re
import subprocess
import sys
import tomllib
from functools import cache

import pytest
from conftest import ROOT

XTASK = ROOT / "target" / "release" / "xtask"
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
FORMS = sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml"))
LINT = "{extends: default, rules: {line-length: {max: 120}, document-start: disable, truthy: {check-keys: false}}}"


def tracked(*patterns):
    listed = subprocess.run(["git", "ls-files", "--", *patterns], cwd=ROOT, check=True, capture_output=True, text=True)
    return [ROOT / name for name in listed.stdout.splitlines()]


def program(*arguments):
    result = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_workflows_and_forms_are_good_yaml():
    program("yamllint", "--strict", "-d", LINT, *map(str, WORKFLOWS + FORMS))


def schema(path):
    if path in WORKFLOWS:
        return "vendor.github-workflows"
    return "vendor.github-issue-config" if path.name == "config.yml" else "vendor.github-issue-forms"


@pytest.mark.parametrize("path", WORKFLOWS + FORMS, ids=lambda path: path.name)
def test_workflows_and_forms_fit_their_schemas(path):
    program("check_jsonschema", "--builtin-schema", schema(path), str(path))


@cache
def help_of(*task):
    shown = subprocess.run([XTASK, *task, "--help"], capture_output=True, text=True)
    return shown.stdout if shown.returncode == 0 else None


def commands(text):
    """The words after `cargo xtask`, until the code ends or a comment or another command begins."""
    text = re.sub(r"\\\n\s*|>-\n\s*", " ", text)
    for match in re.finditer(r"cargo\s+xtask\s+([^`#\n&|;()]*)", text):
        yield match[1].replace(",", " ").split()


def problem(words):
    """The part of a command that does not exist."""
    if not words or words[0].startswith("<"):
        return None
    shown = help_of(words[0])
    if shown is None:
        return f"there is no task `{words[0]}`"
    options = [word.partition("=")[0] for word in words if word.startswith("--")]
    missing = [option for option in options if not re.search(rf"{re.escape(option)}\b(?!-)", shown)]
    return f"`{words[0]}` has no option {missing[0]}" if missing else None


def test_every_command_of_the_task_runner_that_is_named_exists():
    sources = tracked("*.md", "*.yml", "*.toml", ".ci/run", "tests/python/*.py", "cosim/python/*.py")
    found = [
        f"{path.relative_to(ROOT)}: {words}: {why}"
        for path in sources
        if path.name not in ("CHANGELOG.md", "test_workflows.py")
        for words in commands(path.read_text())
        if (why := problem(words))
    ]
    assert not found, "\n".join(found)


def test_a_command_that_does_not_exist_is_seen():
    assert [words for words in commands("`cargo xtask package --all`\ncargo xtask fuzz \\\n  --seconds 3 # x")] == [
        ["package", "--all"],
        ["fuzz", "--seconds", "3"],
    ]
    assert problem(["package", "--all"]) is None
    assert "no task" in problem(["pack"])
    assert "--al" in problem(["package", "--al"])


def test_the_oldest_rust_is_said_once():
    oldest = re.search(r'rust-version = "([\d.]+)"', (ROOT / "Cargo.toml").read_text())[1]
    for path in tracked("*.md", "*.yml"):
        text = path.read_text()
        for said in re.findall(r"Rust (1\.\d+)", text) + re.findall(r"cargo \+(1\.\d+)", text):
            assert said == oldest, f"{path.relative_to(ROOT)} says Rust {said}, Cargo.toml {oldest}"


def test_what_is_built_elsewhere_is_what_the_lock_file_says():
    builds = re.compile(r"cargo (?:\+\S+ )?(?:build|check|test|run|install)\b[^\n&|]*")
    for path in WORKFLOWS:
        for command in builds.findall(path.read_text()):
            assert "--locked" in command, f"{path.name}: {command}"
    alias = tomllib.loads((ROOT / ".cargo/config.toml").read_text())["alias"]["xtask"]
    assert "--locked" in alias.split()
