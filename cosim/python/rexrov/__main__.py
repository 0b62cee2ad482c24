"""`python -m rexrov demo`: course BE3 with realistic sensors and all filters, as a page.
`python -m rexrov component FILE.py:CLASS`: the class as an FMU."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from pathlib import Path

import numpy as np

from . import ComponentError, CosimError, component, report, run, system_path
from .tables import Results, Table

FILTERS = {
    "filter": "model-aided inertial (steers)",
    "dynamic": "dynamic",
    "inertial": "inertial",
    "constant_acceleration": "constant acceleration",
    "ekf_dynamic": "the paper's dynamic",
    "ekf_kinematic": "the paper's kinematic",
}
SECONDS = 330.0
OUTAGE = (200.0, 260.0)


def fly() -> Results:
    """The baseline, without fix and velocity log for a minute, sampled ten times a second."""
    begin, end = OUTAGE
    events = [
        {"time": time, "model": model, "variable": "off", "action": "override", "value": value}
        for time, value in ((begin, 1), (end, 0))
        for model in ("fix", "dvl")
    ]
    return run(
        system_path("baseline"),
        scenario={"description": "neither fix nor velocity log for a minute", "events": events},
        stop_time=SECONDS,
        output_interval=0.1,
        output=["vehicle.pose.?", *(f"{name}.{what}.?" for name in FILTERS for what in ("pose", "sigma"))],
    )


def with_errors(loop: Table) -> Table:
    """Path and estimates, and the horizontal error of each filter beside its own estimate of it."""
    columns = {name: loop[name] for name in loop.dtype.names or ()}
    for name in FILTERS:
        errors = [loop[f"{name}.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"]
        columns[f"{name}.error"] = np.hypot(*errors)
        columns[f"{name}.sigma"] = np.hypot(loop[f"{name}.sigma.x"], loop[f"{name}.sigma.y"])
    table = np.zeros(len(loop), [(column, "f8") for column in columns])
    for column, values in columns.items():
        table[column] = values
    return table


def demo(page: Path) -> None:
    """Runs, writes the page and prints its name."""
    table = with_errors(fly())
    # East to the right, north up.
    truth = ("vehicle.pose.y", "vehicle.pose.x")
    estimates = [(f"{name}.pose.y", f"{name}.pose.x") for name in ("filter", "ekf_dynamic")]
    plots = {
        f"Horizontal error and what the filter thinks it is, {words}, m": [f"{name}.error", f"{name}.sigma"]
        for name, words in FILTERS.items()
    }
    title = f"RexROV on course BE3, neither fix nor velocity log from {OUTAGE[0]:.0f} s to {OUTAGE[1]:.0f} s"
    report(table, page, title=title, plots=plots, paths={"Path, m": [truth, *estimates]})
    last = np.searchsorted(table["time"], OUTAGE[1]) - 1
    for name, words in FILTERS.items():
        rms = float(np.sqrt(np.mean(table[f"{name}.error"] ** 2)))
        print(f"{words}: {rms:.2f} m RMS, {table[f'{name}.error'][last]:.2f} m at the end of the outage")
    print(f"the report is in {page.resolve()}")


def written(named: str, fmu: Path | None, files: list[Path]) -> Path:
    """The FMU of a class given as FILE.py:CLASS."""
    file, _, name = named.rpartition(":")
    path = Path(file)
    if not path.is_file():
        raise ComponentError(f"there is no file {file!r}; name a class as my_ekf.py:MyEkf")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ComponentError(f"{file} is no file of Python: its name must end with .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    sys.path.insert(0, str(path.parent))
    spec.loader.exec_module(module)
    if not hasattr(module, name):
        known = [key for key, value in vars(module).items() if isinstance(value, type) and hasattr(value, "step")]
        raise ComponentError(f"{file} has no class {name!r}; there are {', '.join(known) or 'none with a step'}")
    return component(getattr(module, name), fmu, files=files)


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m rexrov", description=__doc__)
    verbs = parser.add_subparsers(dest="verb", required=True)
    shown = verbs.add_parser("demo", help="write a first report")
    shown.add_argument("-o", "--output-file", type=Path, default=Path("rexrov-demo.html"))
    made = verbs.add_parser("component", help="write the FMU of a Python class")
    made.add_argument("cls", metavar="FILE.py:CLASS")
    made.add_argument("-o", "--output-file", type=Path, metavar="FILE.fmu", help="default: CLASS.fmu")
    made.add_argument("--file", type=Path, action="append", default=[], help="a module that it imports (repeatable)")
    arguments = parser.parse_args()
    try:
        if arguments.verb == "demo":
            demo(arguments.output_file)
        else:
            print(f"written: {written(arguments.cls, arguments.output_file, arguments.file)}")
    except (CosimError, ComponentError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
