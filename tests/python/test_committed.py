"""The committed descriptions say everything about every variable."""

import xml.etree.ElementTree as ET

import pytest
from conftest import NAMES, ROOT

BASE = {"kg", "m", "s", "A", "K", "mol", "cd", "rad"}


@pytest.fixture
def description():
    """The root element of a committed description."""

    def parse(name):
        return ET.parse(ROOT / "modelDescription" / f"{name}.xml").getroot()

    return parse


@pytest.mark.parametrize("name", NAMES)
def test_the_component_says_who_made_it_and_how_to_run_it(description, name):
    root = description(name)
    for attribute in ("description", "author", "version", "copyright", "license"):
        assert root.get(attribute), attribute
    assert root.get("modelName") == name
    experiment = root.find("DefaultExperiment")
    assert float(experiment.get("stopTime")) > float(experiment.get("startTime")) == 0
    assert 0 < float(experiment.get("stepSize")) <= 0.1
    for category in root.find("LogCategories"):
        assert category.get("description"), category.get("name")
    names = {category.get("name") for category in root.find("LogCategories")}
    assert {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"} <= names


@pytest.mark.parametrize("name", NAMES)
def test_every_unit_is_made_of_base_units(description, name):
    for unit in description(name).find("UnitDefinitions"):
        base = unit.find("BaseUnit")
        if base is None:
            # The standard's exponents are whole numbers, so a noise density has none.
            assert "Hz0.5" in unit.get("name")
        elif unit.get("name") not in ("1", "%"):
            assert BASE & set(base.keys()), unit.get("name")


@pytest.mark.parametrize("name", NAMES)
def test_every_real_has_a_unit_and_a_type_that_agree(description, name):
    root = description(name)
    units = {unit.get("name") for unit in root.find("UnitDefinitions")}
    types = {t.get("name"): t for t in root.find("TypeDefinitions")}
    variables = {v.get("name") for v in root.find("ModelVariables")}
    assert not variables & set(types)
    for variable in root.find("ModelVariables"):
        (kind,) = (child for child in variable if child.tag != "Annotations")
        assert variable.get("description"), variable.get("name")
        assert variable.get("variability"), variable.get("name")
        if kind.tag == "Real":
            assert kind.get("unit") in units, variable.get("name")
            declared = types[kind.get("declaredType")].find("Real")
            assert declared.get("unit") == kind.get("unit")
            assert declared.get("quantity")
        if kind.tag == "Enumeration":
            items = types[kind.get("declaredType")].find("Enumeration")
            assert all(item.get("description") for item in items)


@pytest.mark.parametrize("name", NAMES)
def test_what_changes_has_a_nominal_value_and_what_is_bounded_says_so(description, name):
    independent = []
    for variable in description(name).find("ModelVariables"):
        real = variable.find("Real")
        causality = variable.get("causality")
        if causality == "independent":
            independent.append(variable.get("name"))
        elif real is not None and causality in ("input", "output", "local"):
            assert float(real.get("nominal")) > 0, variable.get("name")
        last = variable.get("name").rpartition(".")[2]
        if last in ("valid", "off", "finished"):
            assert (float(real.get("min")), float(real.get("max"))) == (0, 1)
        if last in ("mass", "rate_hz", "volume", "density", "lookahead", "seed", "rate"):
            if causality == "parameter":
                assert float(variable[0].get("min")) >= 0, variable.get("name")
    assert independent == ["time"]
