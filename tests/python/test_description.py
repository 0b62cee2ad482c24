"""The packages as FMPy sees them: complete, and all from one library."""

import zipfile

import pytest
from conftest import NAMES
from fmpy import read_model_description


@pytest.mark.parametrize("name", NAMES)
def test_ports_are_real_and_have_units(fmu, name):
    description = read_model_description(fmu(name))
    for variable in description.modelVariables:
        assert "," not in variable.name
        assert variable.description, f"{variable.name} says nothing of itself"
        if variable.causality in ("input", "output"):
            assert variable.type == "Real", variable.name


@pytest.mark.parametrize("name", NAMES)
def test_archive_is_portable(fmu, name):
    with zipfile.ZipFile(fmu(name)) as archive:
        names = archive.namelist()
        assert names[0] == "modelDescription.xml"
        assert "documentation/index.html" in names
        assert f"binaries/linux64/{name}.so" in names
        assert all(info.date_time == (1980, 1, 1, 0, 0, 0) for info in archive.infolist())


def test_one_library_serves_all(fmu):
    libraries = set()
    for name in NAMES:
        with zipfile.ZipFile(fmu(name)) as archive:
            libraries.add(archive.read(f"binaries/linux64/{name}.so"))
    assert len(libraries) == 1
