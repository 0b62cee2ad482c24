"""Results as a page with pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from . import program, tables
from .runs import PathLike
from .tables import Table


def report(
    results: Table | PathLike,
    page: PathLike,
    *,
    title: str | None = None,
    plots: Mapping[str, Sequence[str]] | None = None,
    paths: Mapping[str, Sequence[tuple[str, str]]] | None = None,
) -> Path:
    """Writes a self-contained HTML page of results, an array or a file, and returns its path.

    `plots` are variables over time by the title of the picture, `paths` are pairs of variables plotted against
    each other; both come before the standard contents of a report.
    """
    with TemporaryDirectory(prefix="rexrov-") as folder:
        if isinstance(results, (str, os.PathLike)):
            file = Path(results)
        else:
            file = Path(folder, "results.csv")
            tables.write(file, results)
        arguments = [f"--output-file={os.fspath(page)}", f"--title={title or file.stem}"]
        for name, columns in (plots or {}).items():
            arguments.append(f"--plot={name}: {', '.join(columns)}")
        for name, pairs in (paths or {}).items():
            arguments.append(f"--xy={name}: {'; '.join(', '.join(pair) for pair in pairs)}")
        program.call("report", *arguments, "--", str(file))
    return Path(page)
