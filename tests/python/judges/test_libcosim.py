"""libcosim as a judge: it reads every variable of every type after every step."""

import numpy as np
import pytest
from conftest import NAMES
from driven import inputs
from libcosim import single
from libcosimpy.CosimEnums import CosimVariableType
from logged import HEALTH

STEP = 0.01
STEPS = 500
# What libcosim reports for every FMU with such variables, from any vendor: its FMI Library expects a start value for the
# independent variable, which FMI forbids (modelon-community/fmi-library#21), and it skips enumerations.
OWN_DEFECTS = (
    "Start attribute is required for this causality, variability and initial combination",
    "FMI 2.0 Enumeration variable type not supported",
)


def complaints(captured):
    lines = (captured.out + captured.err).splitlines()
    return [line for line in lines if not any(own in line for own in (*OWN_DEFECTS, HEALTH))]


@pytest.mark.judge("libcosimpy", "co-simulation, every variable read")
@pytest.mark.parametrize("name", NAMES)
def test_every_variable_is_read_at_every_step(fmu, name, capfd):
    execution = single(fmu(name), STEP)
    signals = inputs(fmu(name), np.arange(STEPS) * STEP)
    references = execution.references("fmu")
    driven = [references[column] for column in signals.dtype.names[1:]]
    seen = 0
    for step in range(STEPS):
        execution.set("fmu", driven, list(signals[step])[1:])
        execution.step()
        seen += sum(len(execution.values("fmu", kind)) for kind in CosimVariableType)
        assert np.isfinite(list(execution.values("fmu").values())).all()
    assert seen == STEPS * len(execution.variables["fmu"])
    del execution
    assert complaints(capfd.readouterr()) == []
