"""One FMU, or a whole system, simulated: results as a numpy structured array."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from . import program, tables
from .errors import CosimError
from .tables import Results, Table

PathLike = str | os.PathLike[str]
#: A start value, of the variable's type; for an enumeration by name or number.
Value = float | int | bool | str
#: A scenario's file, or its content: {"events": [{"time": 1, "model": "dvl", ...}]}.
Scenario = PathLike | Mapping[str, Any]


def simulate(
    fmu: PathLike,
    *,
    start_time: float | None = None,
    stop_time: float | None = None,
    step_size: float | None = None,
    output_interval: float | None = None,
    start_values: Mapping[str, Value] | None = None,
    input: Table | PathLike | None = None,
    output: Sequence[str] | None = None,
    fmi_type: Literal["CoSimulation", "ModelExchange"] | None = None,
    scenario: Scenario | None = None,
    options: Sequence[str] = (),
) -> Results:
    """Simulates one FMU.

    Arguments that are None keep the FMU's values. `start_values` are parameters and inputs by name, `input` is a
    structured array with `time` first, or a CSV file, `output` are names or patterns of the recorded variables
    (by default all outputs). `options` are further options of `cosim simulate`, as on the command line.
    Raises CosimError.
    """
    with TemporaryDirectory(prefix="rexrov-") as folder:
        arguments = _common(folder, start_time, stop_time, output_interval, output, scenario)
        arguments += _pairs("--start-value", start_values)
        arguments += _option("--step-size", step_size)
        if fmi_type is not None:
            arguments += ["--interface-type", {"CoSimulation": "cs", "ModelExchange": "me"}[fmi_type]]
        if isinstance(input, np.ndarray):
            file = Path(folder, "input.csv")
            tables.write(file, input)
            input = file
        if input is not None:
            arguments += ["--input-file", os.fspath(input)]
        return _results("simulate", fmu, folder, [*arguments, *options])


def run(
    system: PathLike,
    *,
    start_time: float | None = None,
    stop_time: float | None = None,
    output_interval: float | None = None,
    start_values: Mapping[str, Value] | None = None,
    replace: Mapping[str, PathLike] | None = None,
    step: Mapping[str, float] | None = None,
    algorithm: Literal["jacobi", "gauss-seidel", "iterative"] | None = None,
    output: Sequence[str] | None = None,
    scenario: Scenario | None = None,
    workers: int | None = None,
    options: Sequence[str] = (),
) -> Results:
    """Runs a system: SSP (.ssd, .ssp) or OSP (a folder or its OspSystemStructure.xml).

    Arguments that are None keep the system's values. Names are `component.variable`; `replace` replaces the FMUs of
    components, `step` gives components other step sizes in seconds, `workers` computes in that
    many processes. `options` are further options of `cosim run`, as on the command line. Raises CosimError.
    """
    with TemporaryDirectory(prefix="rexrov-") as folder:
        arguments = _common(folder, start_time, stop_time, output_interval, output, scenario)
        arguments += _pairs("--start-value", start_values)
        arguments += _pairs("--replace", {k: os.fspath(v) for k, v in (replace or {}).items()})
        arguments += _pairs("--step", step)
        arguments += _option("--algorithm", algorithm)
        arguments += _option("--workers", workers)
        return _results("run", system, folder, [*arguments, *options])


def _common(
    folder: str,
    start_time: float | None,
    stop_time: float | None,
    output_interval: float | None,
    output: Sequence[str] | None,
    scenario: Scenario | None,
) -> list[str]:
    arguments = _option("--start-time", start_time)
    arguments += _option("--stop-time", stop_time)
    arguments += _option("--output-interval", output_interval)
    for name in output or ():
        arguments += _option("--output-variable", name)
    if isinstance(scenario, Mapping):
        file = Path(folder, "scenario.json")
        file.write_text(json.dumps(scenario))
        scenario = file
    return arguments if scenario is None else [*arguments, "--scenario", os.fspath(scenario)]


def _results(verb: str, what: PathLike, folder: str, arguments: list[str]) -> Results:
    file = Path(folder, "results.csv")
    command = [*arguments, "--output-file", str(file), "--", os.fspath(what)]
    try:
        reported = program.call_json(verb, command)
    except CosimError as error:
        if str(file) in str(error):
            raise error.keeping(tables.read(file), str(file)) from None
        raise
    return tables.read(file, reported["columns"])


def _option(name: str, value: Value | None) -> list[str]:
    return [] if value is None else [f"{name}={_text(value)}"]


def _pairs(option: str, values: Mapping[str, Value] | None) -> list[str]:
    return [f"{option}={name}={_text(value)}" for name, value in (values or {}).items()]


def _text(value: Value) -> str:
    """As the command line reads it, with every digit."""
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_)):
        return str(bool(value)).lower()
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(value))
