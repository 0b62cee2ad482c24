"""The checker of the FMU Manipulation Toolbox: schema and semantics of every description."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import NAMES

FMUTOOL = Path(sys.executable).with_name("fmutool")


@pytest.mark.judge("fmu-manipulation-toolbox", "fmutool -check")
@pytest.mark.parametrize("name", NAMES)
def test_fmutool_finds_no_fault(fmu, name):
    run = subprocess.run([FMUTOOL, "-input", fmu(name), "-check"], capture_output=True, text=True)
    said = run.stdout + run.stderr
    assert run.returncode == 0, said
    assert "compliant with FMI-2.0" in said and "No semantic error" in said
    assert not [line for line in said.splitlines() if not line.startswith("INFO")], said
