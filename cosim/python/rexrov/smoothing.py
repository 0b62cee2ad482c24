"""Estimates of every instant of a recorded mission from the whole recording."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import program, tables
from .runs import PathLike, Value
from .tables import Results, Table

#: The navigation filters that can smooth, by the names of their FMUs.
Navigation = Literal["NavConstantAcceleration", "NavDynamic", "NavInertial", "NavModelAided"]


class SmoothingError(RuntimeError):
    """An invalid log or parameter; the message says where, and suggests the intended name."""


def smooth(
    result: Table | Mapping[str, npt.ArrayLike] | PathLike,
    filter: str | None = None,
    *,
    fmu: Navigation = "NavModelAided",
    parameters: Mapping[str, Value] | None = None,
) -> Results:
    """Estimates every instant of a recorded mission from all measurements, earlier and later.

    `result` is that of a system, and `filter` is the component in it whose inputs are used: record them
    with `run(system, output=["filter.*"], output_interval=0.02)`, as often as its fastest sensor
    measures. Or it is a real log: a structured array, arrays by name, or a CSV file, with `time` and
    the inputs of a navigation FMU as names (`dvl.velocity.u`, `dvl.stamp`); a sensor without columns is
    absent, and a row in which its values are NaN has no sample of it. `fmu` is the filter that smooths,
    `parameters` are its start values as in its FMU.

    The table has `time`, at multiples of the filter's interval, and `pose`, `velocity`, `current`,
    `sigma`, `velocity_sigma` and `covariance` under the names of the FMU's outputs. It considers only
    errors that the filter expects: if the filter is inconsistent, so is the result. Raises SmoothingError.
    """
    with TemporaryDirectory(prefix="rexrov-") as folder:
        log, chosen, smoothed = (Path(folder, name) for name in ("log.csv", "parameters.json", "smoothed.csv"))
        if isinstance(result, (str, os.PathLike)):
            log = Path(result)
        else:
            tables.write(log, _columns(result, filter))
        chosen.write_text(json.dumps({name: _plain(value) for name, value in (parameters or {}).items()}))
        command = [str(program.path("rexrov-smooth")), "--quiet", f"--filter={fmu}"]
        command += [f"--parameters={chosen}", f"--output={smoothed}"]
        command += [] if filter is None else [f"--component={filter}"]
        done = subprocess.run(
            [*command, "--", str(log)], stdin=subprocess.DEVNULL, capture_output=True, text=True
        )
        if done.returncode != 0:
            raise SmoothingError(done.stderr.strip().removeprefix("error: "))
        return tables.read(smoothed)


def _columns(result: Table | Mapping[str, npt.ArrayLike], component: str | None) -> Table:
    """The time and the columns that may be inputs, as numbers."""
    names = list(result if isinstance(result, Mapping) else result.dtype.names or ())
    if "time" not in names:
        raise ValueError("there is no column 'time'")
    prefix = "" if component is None else f"{component}."
    wanted = ["time", *(name for name in names if name.startswith(prefix) and name != "time")]
    columns = {name: np.asarray(result[name], "f8") for name in wanted}
    table = np.empty(columns["time"].shape, [(name, "f8") for name in wanted])
    for name, values in columns.items():
        table[name] = values
    return table


def _plain(value: Value) -> Value:
    """A number of numpy as one of Python."""
    return value.item() if isinstance(value, np.generic) else value
