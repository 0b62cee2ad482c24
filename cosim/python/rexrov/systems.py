"""Systems with an additional component."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from .runs import PathLike

_SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
_SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"


def beside(
    system: PathLike, component: str, fmu: PathLike, *, name: str = "mine", output_file: PathLike | None = None
) -> Path:
    """Writes a copy of a system (.ssd) in which an FMU listens, and returns its path, `NAME.ssd` by default.

    The FMU becomes the component `name`. It gets all inputs of `component` that it has; nothing reads its outputs, so the
    run is the same. Its step size is that of `component`.
    """
    source = Path(system).absolute()
    if source.suffix != ".ssd":
        raise ValueError(f"{source} is no .ssd: a package must be unpacked, and an OSP system converted, by `cosim convert`")
    for _, (prefix, uri) in ElementTree.iterparse(source, ["start-ns"]):
        ElementTree.register_namespace(prefix, uri)
    tree = ElementTree.parse(source)
    elements = tree.find(f".//{_SSD}Elements")
    connections = tree.find(f".//{_SSD}Connections")
    components = {} if elements is None else {element.get("name"): element for element in elements}
    if elements is None or connections is None or component not in components:
        raise ValueError(f"{source} has no component '{component}'; there are {', '.join(map(str, components))}")
    if name in components:
        raise ValueError(f"{source} has a component '{name}' already; give the new one another name")
    for element in tree.iter():
        place = element.get("source")
        if place is not None and "://" not in place:
            element.set("source", os.path.normpath(source.parent / place))
    kind = "application/x-fmu-sharedlibrary"
    added = Element(f"{_SSD}Component", name=name, type=kind, source=str(Path(fmu).absolute()))
    connectors = SubElement(added, f"{_SSD}Connectors")
    added.extend(components[component].findall(f"{_SSD}Annotations"))
    elements.append(added)
    inputs = _inputs(Path(fmu))
    for connection in connections.findall(f"{_SSD}Connection"):
        if connection.get("endElement") == component and connection.get("endConnector") in inputs:
            heard = SubElement(connections, connection.tag, connection.attrib | {"endElement": name})
            heard.extend(connection)
            listed = SubElement(connectors, f"{_SSD}Connector", name=connection.get("endConnector", ""), kind="input")
            SubElement(listed, f"{_SSC}Real")
    path = Path(output_file if output_file is not None else f"{name}.ssd")
    tree.write(path, "utf-8", xml_declaration=True)
    return path


def _inputs(fmu: Path) -> set[str]:
    """Names of the inputs of an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    variables = root.iterfind("ModelVariables/ScalarVariable")
    return {variable.get("name", "") for variable in variables if variable.get("causality") == "input"}
