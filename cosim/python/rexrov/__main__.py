"""`python -m rexrov demo`: course BE3 on realistic sensors, every filter beside the others, as a page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from . import CosimError, report, run, system_path
from .tables import Table

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


def fly() -> Table:
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
    """Path and estimates, and the horizontal error of each filter beside what it thinks it is."""
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
    """Runs, writes the page and names it."""
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


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m rexrov", description=__doc__)
    parser.add_argument("what", choices=["demo"], help="write a first report")
    parser.add_argument("-o", "--output-file", type=Path, default=Path("rexrov-demo.html"))
    arguments = parser.parse_args()
    try:
        demo(arguments.output_file)
    except CosimError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
