"""FMUs of other tools in `cosim` and in FMPy: the same values at the same communication points, to 1e-9.

They are not part of this project: FIELD_FMUS names a folder with such FMUs, at any depth. FMPy is stepped directly,
because `simulate_fmu` accumulates rounded step sizes, to which FMUs with variable-step solvers react.
"""

import hashlib
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import cosim
import numpy as np
import pytest
from conftest import COSIM
from fmpy import read_model_description, supported_platforms

FOLDER = os.environ.get("FIELD_FMUS")
pytestmark = pytest.mark.skipif(not FOLDER, reason="FIELD_FMUS names no folder")

TOLERANCE = 1e-9
MOST_STEPS = 2000
MOST_VARIABLES = 100
TYPES = ("Real", "Integer", "Boolean", "Enumeration")
# Clocks of the machine, as in Dymola's FMUs.
CLOCKS = ("CPUtime", "EventCounter")
STEPPED = Path(__file__).with_name("stepped.py")


def found(interface):
    """Each FMU that FMPy can load here for an interface, only once if there are several copies."""
    contents = {}
    for file in sorted(Path(FOLDER).rglob("*.fmu")) if FOLDER else []:
        try:
            described = read_model_description(str(file), validate=False)
        except Exception:  # noqa: BLE001: FMPy has no error of its own for what it cannot read.
            continue
        if described.fmiVersion == "2.0" and getattr(described, interface):
            if zipfile.is_zipfile(file) and "linux64" in supported_platforms(str(file)):
                contents.setdefault(hashlib.sha256(file.read_bytes()).digest(), file)
    return list(contents.values())


def of_all(interface):
    return pytest.mark.parametrize("fmu", found(interface), ids=lambda fmu: str(fmu.relative_to(FOLDER)))


@of_all("coSimulation")
def test_cosim_agrees_with_fmpy(fmu, tmp_path):
    agree(fmu, tmp_path, "cs", [])


@of_all("modelExchange")
def test_cosim_agrees_with_fmpy_in_model_exchange(fmu, tmp_path):
    agree(fmu, tmp_path, "me", ["--solver", "rk4"])


def agree(fmu, folder, interface, options):
    described = read_model_description(str(fmu), validate=False)
    experiment = described.defaultExperiment
    number = lambda name, default: float(getattr(experiment, name, None) or default)  # noqa: E731
    start = number("startTime", 0.0)
    stop = number("stopTime", start + 1.0)
    step = number("stepSize", 0.0) or (stop - start) / 500
    stop = start + step * min(round((stop - start) / step), MOST_STEPS)
    outputs = [v.name for v in described.modelVariables if v.causality == "output" and v.type in TYPES]
    locals_ = [v.name for v in described.modelVariables if v.causality == "local" and v.type == "Real"]
    names = [name for name in outputs or locals_ if name not in CLOCKS][:MOST_VARIABLES]
    if not names:
        pytest.skip("it has no variables to compare")
    chosen = [option for name in names for option in ("--output-variable", name)]
    span = ["--start-time", start, "--stop-time", stop, "--step-size", step]
    output = folder / "out.csv"
    options = [*options, "--interface-type", interface, "--execution-tool", "-q", "-o", output]
    command = [COSIM, "simulate", fmu, *span, *chosen, *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    results = cosim.read(output) if done.returncode == 0 else {"time": [start, start + step]}
    other = subprocess.run(
        [sys.executable, STEPPED, interface, fmu, repr(step), *names],
        input=json.dumps([float(time) for time in results["time"]]), capture_output=True, text=True,
    )
    if other.returncode != 0:
        pytest.skip(f"FMPy cannot run it: {other.stderr.strip().splitlines()[-1:]}")
    assert done.returncode == 0, done.stderr
    wanted = np.array(json.loads(other.stdout.strip().splitlines()[-1])).reshape(-1, len(names)).T
    for name, values in zip(names, wanted):
        np.testing.assert_allclose(results[name], values, rtol=TOLERANCE, atol=TOLERANCE, err_msg=name)
