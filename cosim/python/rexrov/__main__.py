"""`python -m rexrov demo`: the paper's closed loop on course BE3 with either filter, as a page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from . import CosimError, fmu_path, report, run, system_path
from .tables import Table

FILTERS = ("EkfDynamic", "EkfKinematic")
SECONDS = 330.0


def follow(filter: str) -> Table:
    """The loop with a filter, sampled ten times a second."""
    return run(
        system_path("paper"),
        start_values={"pursuit.course": "BE3"},
        replace={"ekf": fmu_path(filter)},
        stop_time=SECONDS,
        output_interval=0.1,
        output=["vehicle.pose.*", "ekf.pose.*", "ekf.sigma.*"],
    )


def compared() -> Table:
    """Path, estimate and error of both, side by side."""
    columns = {}
    for filter in FILTERS:
        loop = follow(filter)
        columns["time"] = loop["time"]
        for axis in "xyz":
            columns[f"{filter}.true.{axis}"] = loop[f"vehicle.pose.{axis}"]
            columns[f"{filter}.estimate.{axis}"] = loop[f"ekf.pose.{axis}"]
        errors = [loop[f"ekf.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"]
        columns[f"{filter}.error"] = np.hypot(*errors)
        columns[f"{filter}.sigma"] = np.hypot(loop["ekf.sigma.x"], loop["ekf.sigma.y"])
    table = np.zeros(len(columns["time"]), [(name, "f8") for name in columns])
    for name, values in columns.items():
        table[name] = values
    return table


def demo(page: Path) -> None:
    """Runs, writes the page and names it."""
    table = compared()
    report(
        table,
        page,
        title="RexROV on course BE3 with either filter",
        plots={
            "Horizontal error of the estimate, m": [f"{f}.{y}" for f in FILTERS for y in ("error", "sigma")],
            "Depth, m": [f"{f}.{y}.z" for f in FILTERS for y in ("true", "estimate")],
        },
        paths={
            f"Path with {f}, m": [(f"{f}.{y}.x", f"{f}.{y}.y") for y in ("true", "estimate")]
            for f in FILTERS
        },
    )
    for filter in FILTERS:
        rms = float(np.sqrt(np.mean(table[f"{filter}.error"] ** 2)))
        print(f"{filter}: horizontal error {rms:.2f} m (RMS over {SECONDS:.0f} s)")
    print(f"the report is in {page.resolve()}")


def main() -> int:
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
