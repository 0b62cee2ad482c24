"""The `cosim` binary, and systems for it as plain data."""

import csv
import subprocess
from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
from conftest import COSIM

SSD = """<?xml version='1.0' encoding='UTF-8'?>
<ssd:SystemStructureDescription version='1.0' name='system' xmlns:cosim='urn:cosim:1'
    xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription'
    xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'
    xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues'>
<ssd:System name='system'>
<ssd:Elements>
{components}</ssd:Elements>
<ssd:Connections>
{connections}</ssd:Connections>
</ssd:System>
<ssd:DefaultExperiment startTime='0' stopTime='{stop_time!r}'/>
</ssd:SystemStructureDescription>
"""
COMPONENT = """<ssd:Component name='{name}' type='application/x-fmu-sharedlibrary' source={source}>
<ssd:Connectors>
{connectors}</ssd:Connectors>
<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
<ssv:ParameterSet version='1.0' name='{name}'><ssv:Parameters>
{parameters}</ssv:Parameters></ssv:ParameterSet>
</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
<ssd:Annotations><ssc:Annotation type='cosim'><cosim:Component stepSize='{step!r}'/></ssc:Annotation></ssd:Annotations>
</ssd:Component>
"""
CONNECTOR = "<ssd:Connector name='{}' kind='{}'><ssc:Real/></ssd:Connector>\n"
PARAMETER = "<ssv:Parameter name='{}'><ssv:Real value='{!r}'/></ssv:Parameter>\n"
CONNECTION = """<ssd:Connection startElement='{}' startConnector='{}' endElement='{}' endConnector='{}'/>
"""


def run(*arguments):
    """Runs the binary; its messages become the error."""
    assert COSIM.exists(), f"{COSIM} is missing: run `cargo build --release -p cosim`"
    command = [COSIM, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def read(file):
    """Columns of a CSV file by name, with every bit of every number."""
    with Path(file).open(newline="") as source:
        header, *rows = csv.reader(source)
    columns = np.array([[float(cell) for cell in row] for row in rows]).T
    return dict(zip(header, columns))


def write_ssd(file, components, connections, stop_time):
    """A system of {name: (FMU, {Real parameter: value}, step)} and [("a.y", "b.u")] as SSP 1.0."""
    ends = [(start.split(".", 1), end.split(".", 1)) for start, end in connections]
    ports = {name: {} for name in components}
    for (a, y), (b, u) in ends:
        ports[a][y], ports[b][u] = "output", "input"
    text = "".join(
        COMPONENT.format(
            name=name,
            source=quoteattr(str(fmu)),
            connectors="".join(CONNECTOR.format(*port) for port in ports[name].items()),
            parameters="".join(PARAMETER.format(*parameter) for parameter in parameters.items()),
            step=step,
        )
        for name, (fmu, parameters, step) in components.items()
    )
    links = "".join(CONNECTION.format(*start, *end) for start, end in ends)
    file.write_text(SSD.format(components=text, connections=links, stop_time=stop_time))
    return file


NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "cosim": "urn:cosim:1",
}


def parts(ssd):
    """A system of SSP 1.0 as {name: (FMU, {parameter: (type, text)}, step as text)} and [("a.y", "b.u")]."""
    root = ElementTree.parse(ssd).getroot()
    components = {}
    for component in root.iterfind(".//ssd:Component", NAMESPACES):
        fmu = Path(ssd).parent.joinpath(component.get("source")).resolve()
        step = component.find(".//cosim:Component", NAMESPACES).get("stepSize")
        values = {}
        for parameter in component.iterfind(".//ssv:Parameter", NAMESPACES):
            (value,) = parameter
            values[parameter.get("name")] = value.tag.split("}")[1], value.get("value")
        components[component.get("name")] = fmu, values, step
    ends = [
        tuple(f"{connection.get(f'{side}Element')}.{connection.get(f'{side}Connector')}" for side in ("start", "end"))
        for connection in root.iterfind(".//ssd:Connection", NAMESPACES)
    ]
    return components, ends
