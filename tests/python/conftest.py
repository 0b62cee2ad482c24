"""Shared by all tests: the packaged FMUs, the `cosim` binary, and the table of the judges' results.

`cargo xtask package` writes the FMUs, `cargo build --release -p cosim` the binary; `cargo xtask judge` does both.
"""

import csv
from importlib.metadata import version
from pathlib import Path

import fmpy.simulation
import pytest

# FMPy passes all messages to the logger of the last simulation that had one, even if it no longer exists
# (fmpy 0.3.32, `addLoggerProxy`): keep them alive.
LOGGERS = []


def kept(logger, make=fmpy.simulation.fmi2CallbackLoggerTYPE):
    LOGGERS.append(make(logger))
    return LOGGERS[-1]


fmpy.simulation.fmi2CallbackLoggerTYPE = kept

ROOT = Path(__file__).resolve().parents[2]
FMUS = ROOT / "target" / "fmus"
COSIM = ROOT / "target" / "release" / "cosim"
# Results of judges that are not written in Python: rows of tool, check, FMU, verdict.
VERDICTS = ROOT / "target" / "judges"
NAMES = [
    "RexROV",
    "Imu",
    "Ahrs",
    "Dvl",
    "Gps",
    "PressureSensor",
    "Tachometer",
    "Disturbance",
    "EkfDynamic",
    "EkfKinematic",
    "NavConstantAcceleration",
    "NavDynamic",
    "NavInertial",
    "NavModelAided",
    "PurePursuit",
    "VelocityController",
]


@pytest.fixture
def fmu():
    """Path of the FMU of a component."""

    def path(name):
        file = FMUS / f"{name}.fmu"
        assert file.exists(), f"{file} is missing: run `cargo xtask package`"
        return str(file)

    return path


def pytest_configure(config):
    config.addinivalue_line("markers", "judge(tool, check): a verdict for the table of judges")
    config.verdicts = {}


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    report = (yield).get_result()
    mark = item.get_closest_marker("judge")
    if mark and report.when == "call":
        package, check = mark.args
        row = item.config.verdicts.setdefault((f"{package} {version(package)}", check), {})
        row[item.callspec.params["name"]] = report.outcome


def pytest_terminal_summary(terminalreporter, config):
    rows = dict(config.verdicts)
    for file in sorted(VERDICTS.glob("*.csv")) if rows else []:
        for tool, check, fmu, verdict in csv.reader(file.open()):
            # A verdict older than the FMU belongs to another FMU.
            places = [folder / f"{fmu}.fmu" for folder in (FMUS, VERDICTS)]
            if any(f.exists() and file.stat().st_mtime > f.stat().st_mtime for f in places):
                rows.setdefault((tool, check), {})[fmu] = verdict
    if not rows:
        return
    terminalreporter.section("judges")
    head = max(len(f"{tool}  {check}") for tool, check in rows)
    others = {name for verdicts in rows.values() for name in verdicts} - set(NAMES)
    names = [*NAMES, *sorted(others)]
    widths = [max(len(name), len("passed")) for name in names]
    heading = [name.center(width) for name, width in zip(names, widths)]
    terminalreporter.write_line(" ".join([" " * head, *heading]))
    for (tool, check), verdicts in sorted(rows.items(), key=lambda row: row[0][0].lower()):
        cells = [verdicts.get(name, "-").center(width) for name, width in zip(names, widths)]
        terminalreporter.write_line(" ".join([f"{tool}  {check}".ljust(head), *cells]))
