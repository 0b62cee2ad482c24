"""The programs `cosim` and `rexrov-smooth` in this package."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import warnings
from collections.abc import Sequence
from importlib.metadata import files
from pathlib import Path
from typing import Any

from . import errors


def cosim_path() -> Path:
    """The path of the program; an activated environment has it as `cosim`."""
    return path("cosim")


def path(name: str) -> Path:
    """The path of a program of this package."""
    for file in files("rexrov") or ():
        if file.name == name and file.parent.name == "bin":
            return Path(os.path.normpath(file.locate()))
    raise FileNotFoundError(f"the program {name} is not in this installation of rexrov: install its wheel again")


def environment() -> dict[str, str]:
    """The environment of the program: FMUs written in Python use this one, with its packages."""
    found = dict(os.environ)
    if sys.executable:
        found["PATH"] = os.pathsep.join([os.path.dirname(sys.executable), found.get("PATH", os.defpath)])
    names = [sysconfig.get_config_var(name) for name in ("LIBDIR", "INSTSONAME")]
    library = os.path.join(*names) if all(names) else ""
    if os.path.isfile(library):
        found.setdefault("COSIM_LIBPYTHON", library)
    return found


def call(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs the program; its errors become exceptions."""
    command = [str(cosim_path()), *arguments]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, env=environment()
    )
    if done.returncode != 0:
        raise errors.of(done)
    return done


def call_json(verb: str, arguments: Sequence[str]) -> Any:
    """Runs a command that answers in JSON; warnings become Python's, messages of FMUs are passed on."""
    done = call(verb, "--format=json", "--quiet", *arguments)
    for line in done.stderr.splitlines():
        if line.startswith("warning: "):
            warnings.warn(line.removeprefix("warning: "), errors.CosimWarning, stacklevel=4)
        else:
            print(line, file=sys.stderr)
    return json.loads(done.stdout)
