"""Results and inputs as numpy structured arrays and as the CSV files of the program."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

#: A structured array: the field `time`, and one for each variable, as of FMPy's simulate_fmu.
Table = npt.NDArray[np.void]

_TYPES = {"Real": "f8", "Integer": "i4", "Enumeration": "i4", "Boolean": "?"}


def read(file: Path, columns: Iterable[Mapping[str, str]] | None = None) -> Table:
    """Results as they were recorded, every bit of them; as Reals if nobody tells the columns' types."""
    if columns is None:
        with file.open(newline="") as source:
            columns = [{"name": name, "type": "Real"} for name in next(csv.reader(source))[1:]]
    kinds = [(column["name"], _TYPES[column["type"]]) for column in columns]
    dtype = np.dtype([("time", "f8"), *kinds])
    return np.loadtxt(file, dtype, comments=None, delimiter=",", skiprows=1, ndmin=1)


def write(file: Path, table: Table) -> None:
    """The fields of a structured array as columns, of which the first must be the time."""
    names = table.dtype.names or ()
    if names[:1] != ("time",):
        raise ValueError(f"the first field must be 'time', not {names[0] if names else 'missing'!r}")
    with file.open("w", newline="") as target:
        writer = csv.writer(target, lineterminator="\n")
        writer.writerow(names)
        # tolist: Python's numbers, which are written so that they read back the same.
        writer.writerows([int(x) if isinstance(x, bool) else x for x in row] for row in table.tolist())
