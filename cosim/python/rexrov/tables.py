"""Results and inputs as numpy structured arrays and as the CSV files of the program."""

from __future__ import annotations

import csv
import html
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

#: A structured array: the field `time`, and one for each variable, as of FMPy's simulate_fmu.
Table = npt.NDArray[np.void]

_TYPES = {"Real": "f8", "Integer": "i4", "Enumeration": "i4", "Boolean": "?"}
#: Bytes of a file that are read at once.
_PIECE = 1 << 24
#: Number of variables shown in a notebook.
_SHOWN = 30


class Results(np.ndarray[tuple[int, ...], np.dtype[np.void]]):
    """The results of a run: a structured array with the field `time` (s) and one for each variable."""

    def __getitem__(self, key: Any) -> Any:
        """A field is a plain array."""
        found = super().__getitem__(key)
        plain = isinstance(found, Results) and found.dtype.names is None
        return found.view(np.ndarray) if plain else found

    def to_pandas(self) -> Any:
        """A data frame with the time (s) as its index; requires pandas."""
        import pandas  # type: ignore[import-untyped]

        columns = {name: np.asarray(self[name]) for name in self._variables()}
        return pandas.DataFrame(columns, index=pandas.Index(np.asarray(self["time"]), name="time"))

    def to_xarray(self) -> Any:
        """A dataset over the coordinate `time` (s); requires xarray."""
        import xarray  # type: ignore[import-not-found,unused-ignore]

        columns = {name: ("time", np.asarray(self[name])) for name in self._variables()}
        return xarray.Dataset(columns, {"time": ("time", np.asarray(self["time"]), {"units": "s"})})

    def _variables(self) -> list[str]:
        return [name for name in self.dtype.names or () if name != "time"]

    def _repr_html_(self) -> str | None:
        """The recorded variables, with the first and the last value, for notebooks."""
        names = self._variables()
        if not names or self.ndim != 1 or len(self) == 0:
            return None
        time, rows = self["time"], []
        for name in names[:_SHOWN]:
            values = np.asarray(self[name], float)
            cells = [values[0], values[-1], values.min(), values.max()]
            rows.append(f"<th>{html.escape(name)}</th>" + "".join(f"<td>{cell:.6g}</td>" for cell in cells))
        more = f"<p>and {len(names) - _SHOWN} more variables</p>" if len(names) > _SHOWN else ""
        head = "<th></th><th>first</th><th>last</th><th>least</th><th>largest</th>"
        body = "".join(f"<tr>{row}</tr>" for row in [head, *rows])
        times = f"{len(self)} instants from {time[0]:g} s to {time[-1]:g} s"
        return f"<p>{times}, {len(names)} variables</p><table>{body}</table>{more}"


def read(file: Path, columns: Iterable[Mapping[str, str]] | None = None) -> Results:
    """Results as they were recorded, to the last bit; as Reals if the columns' types are not given."""
    if columns is None:
        with file.open(newline="") as source:
            columns = [{"name": name, "type": "Real"} for name in next(csv.reader(source))[1:]]
    kinds = [(column["name"], _TYPES[column["type"]]) for column in columns]
    dtype = np.dtype([("time", "f8"), *kinds])
    found = _columns(file, 1 + len(kinds))
    table = np.empty(len(found[0]), dtype)
    for name, values in zip(dtype.names or (), found):
        table[name] = values
    return table.view(Results)


def _columns(file: Path, width: int) -> Sequence[npt.NDArray[np.float64]]:
    """The numbers of a file below its first line: by pandas, the fastest reader, if it is installed."""
    try:
        import pandas
    except ImportError:
        return _plain_columns(file, width)
    with warnings.catch_warnings():
        # Versions before 3 round differently; later ones do not need the option.
        warnings.simplefilter("ignore")
        try:
            frame = pandas.read_csv(file, header=None, skiprows=1, dtype="f8", float_precision="round_trip")
        except pandas.errors.EmptyDataError:
            return [np.empty(0)] * width
    return [frame[place].to_numpy() for place in range(width)]


def _plain_columns(file: Path, width: int) -> Sequence[npt.NDArray[np.float64]]:
    """The same by numpy, in pieces that end with a line."""
    pieces, rest = [np.empty(0)], b""
    with file.open("rb") as source:
        source.readline()
        while piece := source.read(_PIECE):
            whole, end, rest = (rest + piece).rpartition(b"\n")
            pieces.append(np.fromstring((whole + end).replace(b"\n", b",").decode("ascii"), sep=","))
    return list(np.concatenate(pieces).reshape(-1, width).T)


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
