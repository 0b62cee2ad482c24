"""Errors, with the messages of the program."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, replace
from subprocess import CompletedProcess
from typing import Any

from .tables import Results


@dataclass(frozen=True)
class Problem:
    """One problem: what is wrong, where, why, and what to do about it."""

    #: Stable code; `cosim explain E202` says more.
    code: str
    what: str
    #: File, or file:line.
    where: str | None = None
    why: str | None = None
    #: How to fix it.
    help: str | None = None
    #: Messages that the FMU logged.
    log: tuple[str, ...] = ()


class CosimError(RuntimeError):
    """A call that failed; its message is what the command line prints. A check finds all problems at once,
    and a run that failed before its end has `results` up to that point."""

    def __init__(self, text: str, problems: tuple[Problem, ...], results: Results | None = None) -> None:
        super().__init__(text, problems, results)
        self.problems = problems
        self.results = results

    def __str__(self) -> str:
        return str(self.args[0])

    @property
    def code(self) -> str:
        """Code of the first problem."""
        return self.problems[0].code

    @property
    def where(self) -> str | None:
        """File, or file:line, of the first problem."""
        return self.problems[0].where

    @property
    def help(self) -> str | None:
        """How to fix the first problem."""
        return self.problems[0].help


    def keeping(self, results: Results, file: str) -> CosimError:
        """With results that, according to the message, are in a file that will not be kept."""
        kept = "`results` of this error"
        problems = tuple(replace(p, help=p.help and p.help.replace(file, kept)) for p in self.problems)
        return CosimError(str(self).replace(file, kept), problems, results)


class CosimWarning(UserWarning):
    """Something unusual that is not an error."""


def of(done: CompletedProcess[str]) -> CosimError:
    """The error of a program that failed."""
    try:
        reported = json.loads(done.stdout)
        return CosimError(reported["text"], tuple(map(_problem, reported["problems"])))
    except (ValueError, LookupError, TypeError):
        return _untold(done)


def _problem(reported: dict[str, Any]) -> Problem:
    where = reported["file"]
    if where is not None and reported["line"] is not None:
        where = f"{where}:{reported['line']}"
    return Problem(reported["code"], reported["what"], where, reported["why"], reported["help"], tuple(reported["log"]))


def _untold(done: CompletedProcess[str]) -> CosimError:
    """For a command without JSON, an unknown option, or a program that was killed."""
    text = done.stderr.strip().removeprefix("error: ")
    if done.returncode < 0:
        text = f"cosim was killed by signal {-done.returncode}\n{text}".strip()
    code = re.match(r"\[(E\d+)\] ", text)
    what = text.removeprefix(code[0] if code else "").split("\n")[0]
    return CosimError(text, (Problem(code[1] if code else "E001", what),))
