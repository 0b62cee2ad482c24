"""Output of `cosim convert`: other tools can start it, and libcosim gets the same trajectories."""

import csv
import os
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
import xmlschema
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from pyssp_standard.ssd import SSD
from pyssp_standard.ssp import SSP

from conftest import ROOT

STOP = 1.0
STEP = 0.01
# Variables of the loop, compared at every step of 0.1 s.
WATCHED = ["vehicle.pose.x", "vehicle.velocity.u", "imu.rate.r", "ekf.pose.x", "controller.thruster[0].force"]

log_output_level(CosimLogLevel.ERROR)


@pytest.fixture(scope="session")
def cosim():
    """The command line."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "cosim"
    assert program.exists(), f"{program} is missing: run `cargo build --release -p cosim`"

    def run(*arguments):
        done = subprocess.run([program, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done

    return run


@pytest.fixture(scope="session")
def written(cosim, tmp_path_factory):
    """The paper's loop for Jacobi, in every format; the OSP folder is made from the package."""
    folder = tmp_path_factory.mktemp("formats")
    package = folder / "paper.ssp"
    cosim("convert", "examples/paper.ssd", package, "--algorithm", "jacobi", "--stop-time", STOP)
    cosim("convert", package, folder / "osp")
    cosim("convert", folder / "osp", folder / "again.ssd")
    return folder


def of_libcosim(execution):
    """Time series of the watched variables."""
    observer = CosimObserver.create_time_series(buffer_size=1000)
    assert execution.add_observer(observer)
    watched = []
    for name in WATCHED:
        component, variable = name.split(".", 1)
        index = execution.slave_index_from_instance_name(component)
        found = [v for v in execution.slave_variables(index) if v.name.decode() == variable]
        watched.append((index, found[0].reference))
        observer.start_time_series(index, found[0].reference, CosimVariableType.REAL)
    assert execution.simulate_until(int(STOP * 1e9))
    columns = {}
    for name, (index, reference) in zip(WATCHED, watched):
        times, _, values = observer.time_series_real_samples(index, reference, 0, 1000)
        columns[name] = {round(t / 1e9, 9): v for t, v in zip(times, values)}
    return columns


def of_cosim(cosim, system, folder):
    results = folder / "results.csv"
    cosim("run", system, "-q", "-o", results, "--output-interval", 0.1, *sum((["--output-variable", n] for n in WATCHED), []))
    with open(results) as file:
        rows = list(csv.DictReader(file))
    return {name: {round(float(r["time"]), 9): float(r[name]) for r in rows} for name in WATCHED}


@pytest.mark.parametrize("kind", ["paper.ssp", "osp", "again.ssd"])
def test_libcosim_computes_the_same(cosim, written, kind):
    path = str(written / kind)
    start = CosimExecution.from_osp_config_file if kind == "osp" else CosimExecution.from_ssp_file
    theirs = of_libcosim(start(path))
    ours = of_cosim(cosim, written / kind, written)
    for name in WATCHED:
        shared = sorted(set(ours[name]) & set(theirs[name]) - {0.0})
        assert len(shared) >= 9, (name, len(theirs[name]))
        a, b = (np.array([columns[name][t] for t in shared]) for columns in (ours, theirs))
        assert np.allclose(a, b, rtol=1e-9, atol=1e-9), (name, np.abs(a - b).max())


def test_fmpy_runs_the_package(written):
    package = str(written / "paper.ssp")
    results = simulate_ssp(package, stop_time=0.1, step_size=STEP)
    assert "vehicle.pose.x" in results.dtype.names
    assert np.isfinite(results["vehicle.velocity.u"]).all()
    assert len(read_ssd(package).system.elements) == 8


def test_pyssp_standard_finds_nothing_wrong(written):
    with SSP(str(written / "paper.ssp"), mode="r") as package:
        package.system_structure.__check_compliance__()
    with SSD(written / "again.ssd", mode="r") as description:
        description.__check_compliance__()
        assert len(description.system.elements) == 8


def test_the_package_obeys_the_schema_and_the_rules_of_zip(written):
    import pyssp_standard

    schemas = Path(pyssp_standard.__file__).parent / "resources"
    with zipfile.ZipFile(written / "paper.ssp") as package:
        names = package.namelist()
        description = package.read("SystemStructure.ssd")
    assert names[0] == "SystemStructure.ssd"
    assert all(name.isascii() and name.startswith("resources/") for name in names[1:])
    xmlschema.XMLSchema(schemas / "SystemStructureDescription.xsd").validate(description.decode())
