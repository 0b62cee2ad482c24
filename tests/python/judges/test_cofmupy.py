"""CoFmuPy against `cosim`, by Jacobi: the same values step by step, to 1e-9.

It needs another FMPy than these tests, so it has its own environment, whose Python is given by COFMUPY.
"""

import json
import os
import re
import subprocess
from pathlib import Path

import cosim
import element as element_fmu
import numpy as np
import pytest
from conftest import FMUS, ROOT

PYTHON = os.environ.get("COFMUPY")
pytestmark = pytest.mark.skipif(not PYTHON, reason="COFMUPY names no Python with cofmupy")

TOLERANCE = 1e-9
MASTER = Path(__file__).with_name("cofmupy_master.py")


def run(components, ends, step, stop):
    """Columns of all outputs; {name: (FMU, values)} and ends as in `cosim.write_ssd`."""
    side = lambda end: dict(zip(("id", "variable"), end.split(".", 1)))  # noqa: E731
    configuration = {
        "fmus": [
            {"id": name, "path": str(fmu), "initialization": values} for name, (fmu, values) in components.items()
        ],
        "connections": [{"source": side(start), "target": side(end)} for start, end in ends],
        "edge_sep": " -> ",
        "cosim_method": "jacobi",
    }
    system = {"configuration": configuration, "step": step, "stop": stop}
    done = subprocess.run([PYTHON, MASTER], input=json.dumps(system), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_ring_of_elements(tmp_path):
    fmu = element_fmu.pack(tmp_path)
    values = {"clock": {"b": 1.0}, "lag": {"a": -1.0}, "gain": {"k": 2.0, "a": -0.5}}
    ends = [("clock.y", "lag.u"), ("lag.x", "gain.u"), ("gain.x", "clock.u")]
    components = {name: (fmu, given, 0.01) for name, given in values.items()}
    ssd = cosim.write_ssd(tmp_path / "ring.ssd", components, ends, 5.0)
    cosim.run("run", ssd, "--algorithm", "jacobi", "--output-file", tmp_path / "out.csv")
    found = cosim.read(tmp_path / "out.csv")
    wanted = run({name: (fmu, given) for name, given in values.items()}, ends, 0.01, 5.0)
    for name in ["clock.y", "lag.x", "gain.y", "gain.x"]:
        # Its rows are at the ends of steps.
        np.testing.assert_allclose(
            found[name][1:], wanted[name][:500], rtol=TOLERANCE, atol=TOLERANCE, err_msg=name
        )
    assert abs(wanted["gain.x"][-1]) > 0.1


def test_the_loop_of_the_paper(tmp_path):
    """CoFmuPy sets all inputs that are not connected to zero, so the estimate also shows that our components accept that.
    It steps all components together, and sets Reals only: other parameters keep their start values. It passes no values
    between components during initialization, so the first measurements are those of a vehicle at the origin: the filter
    of the paper believes them, which shows in the depth for a while."""
    text = re.sub(r"<ssv:Parameter name=\S+><ssv:(?!Real).*</ssv:Parameter>", "", Path(ROOT, "examples/paper.ssd").read_text())
    ssd, step, stop = tmp_path / "paper.ssd", 0.01, 20.0
    ssd.write_text(text.replace("../target/fmus", str(FMUS)))
    options = ["--step-size", step, "--algorithm", "jacobi", "--output-interval", step, "--stop-time", stop]
    cosim.run("run", ssd, *options, "--output-file", tmp_path / "out.csv")
    found = cosim.read(tmp_path / "out.csv")
    components, ends = cosim.parts(ssd)
    given = {
        name: (fmu, {key: float(text) for key, (_, text) in values.items()})
        for name, (fmu, values, _) in components.items()
    }
    wanted = run(given, ends, step, stop)
    for name in [f"{component}.pose.{axis}" for component in ("vehicle", "ekf") for axis in "xyz"]:
        np.testing.assert_allclose(found[name][101:], wanted[name][100:2000], rtol=0, atol=0.2, err_msg=name)
    assert wanted["ekf.pose.x"][-1] > 5.0
