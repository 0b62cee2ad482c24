"""`python -m rexrov demo`: the paper's closed loop on course BE3 with either filter, as a page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from . import CosimError, fmu_path, report, run, system_path
from .tables import Table

FILTERS = {"dynamic": "EkfDynamic", "kinematic": "EkfKinematic"}
SECONDS = 330.0


def follow(fmu: str) -> Table:
    """The loop with a filter, sampled ten times a second."""
    return run(
        system_path("paper"),
        start_values={"pursuit.course": "BE3"},
        replace={"ekf": fmu_path(fmu)},
        stop_time=SECONDS,
        output_interval=0.1,
        output=["vehicle.pose.*", "ekf.pose.*", "ekf.sigma.*"],
    )


def compared() -> Table:
    """Path, estimate and error of both, side by side."""
    columns = {}
    for name, fmu in FILTERS.items():
        loop = follow(fmu)
        columns["time"] = loop["time"]
        for axis in "xyz":
            columns[f"{name}.true_{axis}"] = loop[f"vehicle.pose.{axis}"]
            columns[f"{name}.{axis}"] = loop[f"ekf.pose.{axis}"]
        errors = [loop[f"ekf.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"]
        columns[f"{name}.error"] = np.hypot(*errors)
        columns[f"{name}.sigma"] = np.hypot(loop["ekf.sigma.x"], loop["ekf.sigma.y"])
    table = np.zeros(len(columns["time"]), [(column, "f8") for column in columns])
    for column, values in columns.items():
        table[column] = values
    return table


def demo(page: Path) -> None:
    """Runs, writes the page and names it."""
    table = compared()
    paths = {
        f"Path with {fmu}, m": [(f"{name}.true_x", f"{name}.true_y"), (f"{name}.x", f"{name}.y")]
        for name, fmu in FILTERS.items()
    }
    plots = {
        f"Horizontal error of {fmu} and what it thinks it is, m": [f"{name}.error", f"{name}.sigma"]
        for name, fmu in FILTERS.items()
    }
    plots["Depth, m"] = [f"{name}.{z}" for name in FILTERS for z in ("true_z", "z")]
    report(table, page, title="RexROV on course BE3 with either filter", plots=plots, paths=paths)
    for name, fmu in FILTERS.items():
        rms = float(np.sqrt(np.mean(table[f"{name}.error"] ** 2)))
        print(f"{fmu}: horizontal error {rms:.2f} m (RMS over {SECONDS:.0f} s)")
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
