"""Many runs and their verdicts, on this machine or with an executor."""

from __future__ import annotations

import csv
import html
import json
import os
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import program
from .errors import CosimError
from .runs import PathLike

#: Exit codes of a missed and of an undecided threshold: verdicts, not failures.
_VERDICTS = ("E404", "E405")


@dataclass(frozen=True)
class Campaign:
    """The results of a campaign, in its folder."""

    folder: Path

    @property
    def summary(self) -> dict[str, Any]:
        """Figures, comparisons and verdicts, as in `summary.json`."""
        summary: dict[str, Any] = json.loads((self.folder / "summary.json").read_text())
        return summary

    @property
    def rows(self) -> list[dict[str, str]]:
        """One row per run: what it was, how it ended, its figures."""
        with (self.folder / "runs.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    @property
    def verdict(self) -> str:
        """`pass`, `fail`, or `undecided`; `none` if there are no thresholds."""
        answers = [_word(verdict["answer"]) for verdict in self.summary["verdicts"]]
        return next((word for word in ("fail", "undecided", "pass") if word in answers), "none")

    def to_pandas(self) -> Any:
        """The rows as a data frame; requires pandas."""
        import pandas  # type: ignore[import-untyped]

        return pandas.read_csv(self.folder / "runs.csv")

    def _repr_html_(self) -> str:
        """The verdicts as a table, for notebooks."""
        head = "<tr><th>cell</th><th>figure</th><th>threshold</th><th>kept</th><th>verdict</th></tr>"
        lines = [
            [v["cell"], v["figure"], v["threshold"], f"{v['kept']} of {v['runs']}", _word(v["answer"])]
            for v in self.summary["verdicts"]
        ]
        cells = ["".join(f"<td>{html.escape(str(cell))}</td>" for cell in line) for line in lines]
        rows = "".join(f"<tr>{line}</tr>" for line in cells)
        return f"<p>{html.escape(str(self.folder))}: {self.verdict}</p><table>{head}{rows}</table>"


def campaign(
    file: PathLike,
    *,
    output_dir: PathLike | None = None,
    executor: Executor | None = None,
    shards: int | None = None,
    jobs: int | None = None,
) -> Campaign:
    """Makes the runs of a campaign file and evaluates them; runs that already exist in `output_dir` are kept.

    Without an executor this machine makes `jobs` runs at once, one per core by default. An executor with the interface
    of `concurrent.futures` (a pool of processes or threads, `Client.get_executor()` of dask, submitit's) gets `shards`
    parts, by default one per worker, each with `jobs` runs at once, 1 by default. Its workers need this package, and must
    see the file, the FMUs and `output_dir` under the same paths. An interrupted part continues where it stopped. The rows
    are the same in all cases.

    A missed threshold is not an error but a verdict. Raises CosimError.
    """
    path = Path(file).absolute()
    folder = Path(output_dir if output_dir is not None else f"{path.stem}_campaign").absolute()
    if executor is None:
        _call(str(path), f"--output-dir={folder}", *([] if jobs is None else [f"--jobs={jobs}"]))
        return Campaign(folder)
    count = shards or _workers(executor)
    parts = [f"{part}/{count}" for part in range(1, count + 1)]
    make: Callable[..., Future[None]] = executor.submit
    futures = [make(_shard, str(path), part, str(folder), jobs or 1) for part in parts]
    for future in futures:
        future.result()
    merged = [f"--merge={folder / 'shard-{}-of-{}'.format(*part.split('/'))}" for part in parts]
    _call(*merged, f"--output-dir={folder}")
    return Campaign(folder)


def _shard(file: str, part: str, folder: str, jobs: int) -> None:
    """Makes a part, on a worker of the executor."""
    _call(file, f"--shard={part}", f"--output-dir={folder}", f"--jobs={jobs}")


def _workers(executor: Executor) -> int:
    """The number of workers of an executor; if it does not report it, the number of cores of this machine."""
    count = getattr(executor, "_max_workers", None)
    return count if isinstance(count, int) and count > 0 else os.cpu_count() or 1


def _call(*arguments: str) -> None:
    try:
        program.call("campaign", "--quiet", "--csv", *arguments)
    except CosimError as error:
        if error.code not in _VERDICTS:
            raise


def _word(answer: Any) -> str:
    """An answer of `summary.json`: a word, or a word with the number of seeds that are needed."""
    return (answer if isinstance(answer, str) else next(iter(answer))).lower()
