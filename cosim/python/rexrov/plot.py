"""The usual pictures, with matplotlib, which must be installed: `rexrov.plot.path(result)`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .tables import Table


def path(results: Table, truth: str = "vehicle.pose", estimates: Sequence[str] | None = None, *, ax: Any = None) -> Any:
    """Draws paths seen from above, north up and east right on the same scale, and returns the axes.

    `truth` and `estimates` are names whose `.x` (north) and `.y` (east) were recorded, in m; without `estimates`
    all other names that end with `.pose` are used.
    """
    names = results.dtype.names or ()
    known = [name.removesuffix(".x") for name in names if name.endswith(".x") and f"{name[:-2]}.y" in names]
    if estimates is None:
        estimates = [name for name in known if name.endswith(".pose") and name != truth]
    for name in (truth, *estimates):
        if name not in known:
            raise ValueError(f"'{name}.x' and '{name}.y' were not recorded; there are {', '.join(known) or 'no positions'}")
    if ax is None:
        from matplotlib import pyplot  # type: ignore[import-not-found,unused-ignore]

        ax = pyplot.figure().add_subplot()
    for name in estimates:
        ax.plot(results[f"{name}.y"], results[f"{name}.x"], linewidth=1, label=name)
    north, east = results[f"{truth}.x"], results[f"{truth}.y"]
    ax.plot(east, north, color="black", linewidth=1, linestyle="--", label=truth)
    ax.plot(east[:1], north[:1], color="black", marker="o", linestyle="none", label="start")
    ax.set(xlabel="east (m)", ylabel="north (m)", aspect="equal", adjustable="datalim")
    ax.grid(alpha=0.3)
    ax.legend()
    return ax
