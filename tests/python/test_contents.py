"""The contents of an FMU besides description and library, and whether its reference result is correct."""

import io
import re
import struct
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest
from conftest import NAMES
from fmpy import read_model_description, simulate_fmu
from fmpy.util import read_csv

REFERENCE = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "{http://fmi-standard.org/fmi-ls-manifest}"
# The roles of FMI-LS-REF, section "Related Files".
ROLES = re.compile(
    "document|requirement|specification|model|parameter|system|testcase|result|method|rationale|report|request|delivery"
    "|configuration|signature|meta-data|other|experiment(/(smoke-test|validation|uncertainty-analysis))?"
    "|serialized-state(/.*)?"
)


def read(path, name):
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)


def table(path, name):
    """A CSV file of an FMU as a structured array."""
    return np.genfromtxt(io.BytesIO(read(path, name)), delimiter=",", names=True, deletechars="")


def has_inputs(path):
    return any(v.causality == "input" for v in read_model_description(path).modelVariables)


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_gets_the_reference_result_from_the_reference_inputs(fmu, name, tmp_path):
    path = fmu(name)
    file = tmp_path / "in.csv"
    if has_inputs(path):
        file.write_bytes(read(path, f"{REFERENCE}/{name}_in.csv"))
    expected = table(path, f"{REFERENCE}/{name}_out.csv")
    variables = [v for v in expected.dtype.names if v != "time"]
    stop = read_model_description(path).defaultExperiment.stopTime
    result = simulate_fmu(
        path,
        fmi_type="CoSimulation",
        stop_time=float(stop),
        output_interval=0.1,
        input=read_csv(str(file)) if file.exists() else None,
        output=variables,
    )
    assert len(result) == len(expected) == round(float(stop) / 0.1) + 1
    moved = False
    for variable in ["time", *variables]:
        np.testing.assert_allclose(
            result[variable], expected[variable], rtol=1e-9, atol=1e-9, err_msg=variable
        )
        moved |= variable != "time" and np.ptp(expected[variable]) > 0.01
    assert moved, "a result in which nothing happens says nothing"


@pytest.mark.parametrize("name", NAMES)
def test_the_manifest_fits_its_standard_and_lists_what_is_there(fmu, name):
    path = fmu(name)
    manifest = ET.fromstring(read(path, f"{REFERENCE}/fmi-ls-manifest.xml"))
    assert manifest.tag == "fmiReferences"
    assert manifest.attrib == {
        f"{MANIFEST}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
        f"{MANIFEST}fmi-ls-version": "1.0.0-alpha.1",
        f"{MANIFEST}fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
    }
    for related in manifest:
        assert related.tag == "Related" and {"source", "role"} <= set(related.keys())
        assert set(related.keys()) <= {"type", "source", "role", "description"}
        assert ROLES.fullmatch(related.get("role")), related.get("role")
    sources = {related.get("source") for related in manifest.iter("Related")}
    expected = {f"{name}_in.csv", f"{name}_out.csv"} if has_inputs(path) else {f"{name}_out.csv"}
    assert sources == expected
    with zipfile.ZipFile(path) as archive:
        assert sources <= {entry.rpartition("/")[2] for entry in archive.namelist()}


@pytest.mark.parametrize("name", NAMES)
def test_the_page_has_equations_a_plot_and_every_variable(fmu, name):
    path = fmu(name)
    page = read(path, "documentation/index.html").decode()
    assert "<math" in page and "<svg" in page and 'src="../model.png"' in page
    # Nothing is left that should have become an equation, and nothing comes from elsewhere.
    assert "$$" not in page and "\\mathbf" not in page
    for foreign in ('src="http', 'href="http', "@import", "url(http"):
        assert foreign not in page
    for variable in read_model_description(path).modelVariables:
        if variable.causality in ("input", "output", "parameter"):
            assert f"<code>{variable.name}</code>" in page


@pytest.mark.parametrize("name", NAMES)
def test_the_icon_is_a_square_picture(fmu, name):
    png = read(fmu(name), "model.png")
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24]) == (256, 256)


@pytest.mark.parametrize("name", NAMES)
def test_the_licences_are_there(fmu, name):
    path = fmu(name)
    entry = read(path, "documentation/licenses/license.txt").decode()
    for part in ("MIT", "Apache-2.0", "serde v", "libm v"):
        assert part in entry
    assert b"Permission is hereby granted" in read(path, "documentation/licenses/LICENSE-MIT")
    assert b"Apache License" in read(path, "documentation/licenses/LICENSE-APACHE")
