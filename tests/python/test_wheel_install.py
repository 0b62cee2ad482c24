"""The wheel in a clean environment: only Python, pip and the wheel's dependencies."""

import hashlib
import os
import re
import shutil
import subprocess
import time
import zipfile
from pathlib import Path

import pytest
from conftest import NAMES, ROOT

TARGET = ROOT / "target"
GLIBC = re.compile(rb"GLIBC_2\.(\d+)")
WHEEL = next((TARGET / "wheels").glob("*.whl"), None)
assert WHEEL, "no wheel in target/wheels: run `cargo xtask wheel`"


@pytest.fixture(scope="module")
def clean():
    """The programs of an environment in which the wheel was just installed."""
    folder = TARGET / "wheel-venv"
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run(["python3", "-m", "venv", folder], check=True)
    begun = time.monotonic()
    pip = [folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "--only-binary", ":all:", WHEEL], check=True)
    print(f"{WHEEL.name}: {WHEEL.stat().st_size / 1e6:.1f} MB, installed in {time.monotonic() - begun:.1f} s")
    return folder / "bin"


def call(clean, *command, cwd):
    """Runs a program of the clean environment, which sees no compiler and no other program."""
    environment = {"PATH": str(clean), "HOME": str(cwd), "TMPDIR": str(cwd)}
    done = subprocess.run(
        [clean / command[0], *command[1:]], cwd=cwd, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_asks_for_numpy_and_the_glibc_in_its_name_only():
    with zipfile.ZipFile(WHEEL) as archive:
        names = archive.namelist()
        (metadata,) = [name for name in names if name.endswith("METADATA")]
        lines = archive.read(metadata).decode().splitlines()
        tag = archive.read(metadata.replace("METADATA", "WHEEL")).decode()
        programs = [name for name in names if name.endswith(("/cosim", ".so"))]
        asked = {int(minor) for name in programs for minor in GLIBC.findall(archive.read(name))}
    assert [line for line in lines if line.startswith("Requires-Dist")] == ["Requires-Dist: numpy>=1.26"]
    (minor,) = re.findall(r"py3-none-manylinux_2_(\d+)_", WHEEL.name)
    assert f"Tag: py3-none-manylinux_2_{minor}_" in tag
    assert len(programs) > 2 and asked and max(asked) <= int(minor), asked
    for wanted in ["rexrov/py.typed", "LICENSE-MIT", "LICENSE-LINKED", *(f"fmus/{name}.fmu" for name in NAMES)]:
        assert any(name.endswith(wanted) for name in names), wanted


def test_the_same_files_give_the_same_bytes(tmp_path):
    again = tmp_path / "later"
    shutil.copytree(TARGET / "wheel", again, copy_function=shutil.copy)
    version, machine = WHEEL.name.split("-")[1], WHEEL.name.removesuffix(".whl").split("-", 2)[2]
    variables = {"REXROV_VERSION": version, "REXROV_TAG": machine}
    build = [TARGET / "zig" / "bin" / "hatchling", "build", "-t", "wheel", "-d", tmp_path]
    subprocess.run(build, check=True, cwd=again, env=os.environ | variables, capture_output=True)
    digests = {hashlib.sha256(file.read_bytes()).hexdigest() for file in (WHEEL, tmp_path / WHEEL.name)}
    assert len(digests) == 1


def test_the_first_picture_takes_less_than_ten_seconds(clean, tmp_path):
    begun, before = time.monotonic(), os.times()
    said = call(clean, "python", "-m", "rexrov", "demo", cwd=tmp_path)
    after = os.times()
    # Processor time, so that other processes on the machine are not counted.
    spent = after.children_user - before.children_user + after.children_system - before.children_system
    print(f"python -m rexrov demo: {time.monotonic() - begun:.1f} s, {spent:.1f} s of the processor")
    page = Path(said.strip().splitlines()[-1].removeprefix("the report is in "))
    assert page.parent == tmp_path and page.read_text().count('"section"') >= 4
    assert [file.name for file in tmp_path.iterdir()] == [page.name], "nothing else stays behind"
    assert spent < 10


def test_the_master_exports_the_system(clean, tmp_path):
    script = "import rexrov; print(rexrov.system_path('paper'))"
    system = call(clean, "python", "-c", script, cwd=tmp_path).strip()
    call(clean, "cosim", "export", system, "-o", "Loop.fmu", cwd=tmp_path)
    options = ["--stop-time=2", "--output-variable=*pose.x"]
    loop = call(clean, "cosim", "simulate", "Loop.fmu", *options, "-q", "-o", "-", cwd=tmp_path)
    assert "ekf.pose.x" in loop.splitlines()[0] and len(loop.splitlines()) > 10
