"""A Python class as a component: an FMU whose library steps an object of the class."""

from __future__ import annotations

import hashlib
import inspect
import itertools
import json
import os
import platform
import re
import subprocess
import sys
import warnings
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from . import program, units
from .errors import CosimWarning
from .runs import PathLike

#: FMI's type of a parameter by the type of its default value; a bool is an int, too.
_TYPES: dict[type, str] = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}
_LIBRARY = "libcosim_scripted.so"
_STRUCTURED = re.compile(r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?(\.[A-Za-z_]\w*(\[\d+(,\d+)*\])?)*")
#: The form of `component.json`, which the library checks.
_VERSION = 1


class ComponentError(ValueError):
    """A class that cannot be a component; the message says what is missing or wrong."""


def component(cls: type, fmu: PathLike | None = None, *, files: Sequence[PathLike] = ()) -> Path:
    """Writes the FMU of a class, `NAME.fmu` by default, and returns its path.

    The class needs

    - `rate`, how often it is stepped (Hz);
    - `inputs` and `outputs`, units by name: `{"dvl.velocity.{u,v,w}": "m/s"}` declares three. All are Reals;
    - `step(self, t, y)`, which gets the time (s) and the measurements, and returns the estimate. `y[name]` is an
      input, `y["dvl.velocity"]` an array of all inputs below that name, and `y.new("dvl")` is true if a sensor's `stamp`
      has changed while its `valid` is 1. The estimate has each output by name, or arrays by the names of groups
      (`{"pose": [x, y, z, yaw]}`); or it is one array of all outputs.

    The keyword arguments of `__init__` are parameters. Their types and start values are those of the default values,
    and their units are in `parameters`, by name. The object is created, and stepped first, at the start of
    the simulation. Its attributes are its state: if they can be pickled, the FMU's state can be saved.

    The class's file is packed; your other modules that it imports must be given as `files`. Packages are those of
    this Python, which runs the class. Raises ComponentError.
    """
    if "REXROV_HOST" in os.environ:
        raise ComponentError(
            f"{os.environ['REXROV_HOST']} writes its own FMU while the FMU imports it; "
            "put what is to be run under `if __name__ == '__main__':`"
        )
    source = _source(cls)
    inputs, outputs = _ports(cls, "inputs"), _ports(cls, "outputs")
    both = sorted(inputs.keys() & outputs.keys())
    if both:
        raise ComponentError(f"{cls.__name__}: '{both[0]}' is an input and an output")
    if not outputs:
        raise ComponentError(f"{cls.__name__} has no outputs")
    if not callable(getattr(cls, "step", None)):
        raise ComponentError(f"{cls.__name__} has no method step(self, t, y)")
    manifest = {
        "version": _VERSION,
        "guid": "",
        "class": cls.__name__,
        "module": source.name,
        "python": sys.executable,
        "rate": _rate(cls),
        "inputs": list(inputs),
        "outputs": list(outputs),
        "parameters": list(_parameters(cls)),
    }
    entries = {f"resources/code/{source.name}": source.read_bytes()}
    for file in map(Path, files):
        entries[f"resources/code/{file.name}"] = file.read_bytes()
    entries["resources/host.py"] = Path(__file__).with_name("host.py").read_bytes()
    entries[f"binaries/linux64/{cls.__name__}.so"] = _library().read_bytes()
    saved = _checked(manifest, entries)
    described = _description(cls, manifest, inputs | outputs, saved)
    parts = [json.dumps(manifest).encode(), described, *(entries[name] for name in sorted(entries))]
    digest = hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
    manifest["guid"] = f"{{{'-'.join(digest[a:b] for a, b in itertools.pairwise((0, 8, 12, 16, 20, 32)))}}}"
    entries["resources/component.json"] = json.dumps(manifest, indent=2).encode()
    described = _description(cls, manifest, inputs | outputs, saved)
    path = Path(fmu if fmu is not None else f"{cls.__name__}.fmu")
    _write(path, {"modelDescription.xml": described, **entries})
    return path


def _source(cls: type) -> Path:
    """The file that contains a class."""
    if not inspect.isclass(cls):
        raise ComponentError(f"{cls!r} is no class")
    if cls.__qualname__ != cls.__name__:
        raise ComponentError(f"{cls.__qualname__} must be at the top of its file, to be found there")
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    if file is None or not os.path.isfile(file):
        raise ComponentError(
            f"{cls.__name__} is in no file; write it to one (in a notebook: %%writefile NAME.py) and import it"
        )
    return Path(file)


def _rate(cls: type) -> float:
    rate = getattr(cls, "rate", None)
    if isinstance(rate, bool) or not isinstance(rate, (int, float)) or not 1e-3 <= rate <= 1e6:
        raise ComponentError(f"{cls.__name__}.rate is {rate!r}; it must say how often step is called, in Hz")
    return float(rate)


def _ports(cls: type, which: str) -> dict[str, str]:
    """Units by name, with braces expanded."""
    declared = getattr(cls, which, None)
    if declared is None:
        raise ComponentError(f"{cls.__name__}.{which} is missing: units by name, as {{'pose.x': 'm'}}")
    if not isinstance(declared, Mapping):
        raise ComponentError(f"{cls.__name__}.{which} must be a dictionary of units by name")
    found: dict[str, str] = {}
    for pattern, unit in declared.items():
        for name in _expanded(pattern):
            if not name or name != name.strip() or any(c in name for c in ",\n{}"):
                raise ComponentError(f"{cls.__name__}.{which}: '{pattern}' is no name of a variable")
            if name in found:
                raise ComponentError(f"{cls.__name__}.{which} has '{name}' twice")
            found[name] = _unit(unit, f"{cls.__name__}.{which}['{pattern}']")
    return found


def _expanded(pattern: str) -> Iterator[str]:
    """`a.{x,y}` as `a.x` and `a.y`."""
    parts = re.split(r"\{([^{}]*)\}", pattern)
    choices = [part.split(",") if place % 2 else [part] for place, part in enumerate(parts)]
    return map("".join, itertools.product(*choices))


def _unit(unit: str, where: str) -> str:
    try:
        units.base(unit)
    except ValueError as error:
        raise ComponentError(f"{where}: {error}") from None
    return unit


def _parameters(cls: type) -> Iterator[dict[str, Any]]:
    """The keyword arguments of `__init__`."""
    declared = getattr(cls, "parameters", {})
    own = getattr(cls, "__init__") is not object.__init__
    arguments = dict(inspect.signature(cls).parameters) if own else {}
    kinds = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    arguments = {name: argument for name, argument in arguments.items() if argument.kind not in kinds}
    for name in declared:
        if name not in arguments:
            raise ComponentError(f"{cls.__name__}.parameters has '{name}', which is no argument of __init__")
    for name, argument in arguments.items():
        start = argument.default
        where = f"{cls.__name__}.__init__: argument '{name}'"
        if start is inspect.Parameter.empty:
            raise ComponentError(f"{where} needs a default value, which is the start value of the parameter")
        kind = next((kind for python, kind in _TYPES.items() if isinstance(start, python)), None)
        if kind is None:
            raise ComponentError(f"{where} is {start!r}; a parameter is a number, a bool or a text")
        unit = _unit(declared.get(name, ""), f"{cls.__name__}.parameters['{name}']")
        yield {"name": name, "type": kind, "start": start, "unit": unit}


def _library() -> Path:
    """The library of all these FMUs."""
    beside = program.cosim_path().resolve().parent
    named = os.environ.get("COSIM_SCRIPTED_LIBRARY")
    folders = [beside, *sorted(beside.parent.glob("lib/cosim/*/"))]
    places = [Path(named)] if named else [folder / _LIBRARY for folder in folders]
    for place in places:
        if place.is_file():
            return place
    raise ComponentError(f"the library {_LIBRARY} is not in this installation of rexrov: install its wheel again")


def _checked(manifest: dict[str, Any], entries: Mapping[str, bytes]) -> bool:
    """Creates an object as the FMU will; returns whether its state can be saved."""
    with TemporaryDirectory(prefix="rexrov-") as folder:
        for name, octets in {**entries, "resources/component.json": json.dumps(manifest).encode()}.items():
            file = Path(folder, name)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(octets)
        resources = Path(folder, "resources")
        command = [sys.executable, "-P", "-B", str(resources / "host.py"), str(resources), "--check"]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    try:
        found = json.loads(done.stdout)
    except ValueError:
        raise ComponentError(f"{manifest['module']} ends the Python that imports it: {done.stderr}") from None
    if "wrong" in found:
        hint = "; name modules of yours by files=" if "ModuleNotFoundError" in found["wrong"] else ""
        raise ComponentError(found["wrong"] + hint)
    if "unsaved" in found:
        text = f"the state of {manifest['class']} cannot be saved: {found['unsaved']}; runs of it cannot be resumed"
        warnings.warn(text, CosimWarning, stacklevel=3)
    return "unsaved" not in found


def _description(cls: type, manifest: Mapping[str, Any], ports: Mapping[str, str], saved: bool) -> bytes:
    """The modelDescription.xml."""
    name, names = cls.__name__, [*ports, *(parameter["name"] for parameter in manifest["parameters"])]
    structured = all(map(_STRUCTURED.fullmatch, names))
    root = Element("fmiModelDescription", fmiVersion="2.0", modelName=name, guid=manifest["guid"])
    root.attrib |= {
        "description": (inspect.getdoc(cls) or f"The Python class {name}").split("\n\n")[0].replace("\n", " "),
        "generationTool": f"rexrov with Python {platform.python_version()}",
        "variableNamingConvention": "structured" if structured else "flat",
        "numberOfEventIndicators": "0",
    }
    flags = {"needsExecutionTool": True, "canHandleVariableCommunicationStepSize": True}
    flags |= {"canNotUseMemoryManagementFunctions": True, "canGetAndSetFMUstate": saved}
    flags |= {"canSerializeFMUstate": saved}
    interface = SubElement(root, "CoSimulation", modelIdentifier=name)
    interface.attrib |= {flag: str(value).lower() for flag, value in flags.items()}
    used = dict.fromkeys([*ports.values(), *(parameter["unit"] for parameter in manifest["parameters"])])
    used.pop("", None)
    if used:
        definitions = SubElement(root, "UnitDefinitions")
        for unit in used:
            definition = SubElement(definitions, "Unit", name=unit)
            SubElement(definition, "BaseUnit", units.base(unit))
    rate = manifest["rate"]
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=repr(1.0 / rate))
    variables = SubElement(root, "ModelVariables")
    counts = {kind: itertools.count() for kind in _TYPES.values()}

    def add(name: str, causality: str, variability: str, kind: str, unit: str, start: Any, **more: str) -> None:
        reference = str(next(counts[kind]))
        variable = SubElement(variables, "ScalarVariable", name=name, valueReference=reference)
        variable.attrib |= {"causality": causality, "variability": variability, **more}
        typed = SubElement(variable, kind, {"unit": unit} if unit else {})
        if start is not None:
            typed.set("start", str(start).lower() if kind == "Boolean" else str(start))

    for port in manifest["inputs"]:
        add(port, "input", "continuous", "Real", ports[port], 0.0)
    for port in manifest["outputs"]:
        add(port, "output", "discrete", "Real", ports[port], None)
    for parameter in manifest["parameters"]:
        kind, unit, start = parameter["type"], parameter["unit"], parameter["start"]
        add(parameter["name"], "parameter", "fixed", kind, unit, start, initial="exact")
    structure = SubElement(root, "ModelStructure")
    first = len(manifest["inputs"]) + 1
    for part in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(structure, part)
        for index in range(first, first + len(manifest["outputs"])):
            SubElement(unknowns, "Unknown", index=str(index))
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, "utf-8", xml_declaration=True)
    return text + b"\n"


def _write(path: Path, entries: Mapping[str, bytes]) -> None:
    """The archive, under its name only when it is complete: the same bytes for the same class."""
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, octets in entries.items():
                entry = zipfile.ZipInfo(name)
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, octets, zipfile.ZIP_DEFLATED)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
