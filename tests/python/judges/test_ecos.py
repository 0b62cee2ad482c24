"""Ecos against `cosim`: the same states step by step, to 1e-9. Ecos steps by Jacobi."""

import json
import subprocess
import sys
from pathlib import Path

import cosim
import element as element_fmu
import numpy as np
import pytest
from conftest import FMUS, NAMES, ROOT

TOLERANCE = 1e-9
MASTER = Path(__file__).with_name("ecos_master.py")


def run(system):
    """Columns of the outputs: in a separate process, because its libraries stay loaded until it ends."""
    done = subprocess.run([sys.executable, MASTER], input=json.dumps(system), capture_output=True, text=True)
    if "libtbb" in done.stderr or "GLIBC" in done.stderr:
        pytest.skip(f"Ecos does not run here: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout.strip().splitlines()[-1])
    return dict(zip(system["outputs"], np.array(rows).T))


def test_a_ring_of_elements(tmp_path):
    fmu = element_fmu.pack(tmp_path)
    values = {"clock": {"b": 1.0}, "lag": {"a": -1.0}, "gain": {"k": 2.0, "a": -0.5}}
    ends = [("clock.y", "lag.u"), ("lag.x", "gain.u"), ("gain.x", "clock.u")]
    components = {name: (fmu, given, 0.01) for name, given in values.items()}
    ssd = cosim.write_ssd(tmp_path / "ring.ssd", components, ends, 5.0)
    cosim.run("run", ssd, "--algorithm", "jacobi", "--output-file", tmp_path / "out.csv")
    found = cosim.read(tmp_path / "out.csv")
    names = lambda end: end.replace(".", "::")  # noqa: E731
    wanted = run({
        "step": 0.01,
        "steps": 500,
        "models": {name: str(fmu) for name in values},
        "values": {f"{name}::{key}": value for name, given in values.items() for key, value in given.items()},
        "connections": [[names(start), names(end)] for start, end in ends],
        # Ecos records feed-through outputs as they are after the next inputs were set.
        "outputs": [f"{name}::x" for name in values],
    })
    for name, column in wanted.items():
        np.testing.assert_allclose(
            found[name.replace("::", ".")], column, rtol=TOLERANCE, atol=TOLERANCE, err_msg=name
        )
    assert abs(wanted["gain::x"][-1]) > 0.1


def test_the_loop_of_the_paper(tmp_path):
    """All components have the same step, because Ecos holds inputs differently from cosim between rates. It applies
    only the parameter sets of one name."""
    assert (FMUS / "RexROV.fmu").exists(), "run `cargo xtask package`"
    ssp = tmp_path / "loop.ssp"
    cosim.run("convert", ROOT / "examples" / "paper.ssd", ssp, "--step-size", 0.01)
    options = ["--algorithm", "jacobi", "--output-interval", 0.01, "--stop-time", 20]
    cosim.run("run", ssp, *options, "--output-file", tmp_path / "out.csv")
    found = cosim.read(tmp_path / "out.csv")
    names = [f"{component}.pose.{axis}" for component in ("vehicle", "ekf") for axis in "xyz"]
    wanted = run({
        "step": 0.01, "steps": 2000, "ssp": str(ssp), "set": "parameters",
        "outputs": [name.replace(".", "::", 1) for name in names],
    })
    for name, column in zip(names, wanted.values()):
        np.testing.assert_allclose(found[name], column, rtol=TOLERANCE, atol=TOLERANCE, err_msg=name)
    assert wanted["vehicle::pose.x"][-1] > 5.0


@pytest.mark.judge("ecospy", "co-simulation, stepped")
@pytest.mark.parametrize("name", NAMES)
def test_every_component_is_stepped(name):
    fmu = FMUS / f"{name}.fmu"
    assert fmu.exists(), f"{fmu} is missing: run `cargo xtask package`"
    columns = run({
        "step": 0.01, "steps": 200, "models": {"it": str(fmu)}, "values": {}, "connections": [], "outputs": ["it::time"],
    })
    np.testing.assert_allclose(columns["it::time"], np.arange(201) * 0.01, atol=1e-9)
