"""FMPy as a judge of every FMU: the archive and each interface that it can use."""

import numpy as np
import pytest
from conftest import NAMES
from driven import inputs, staircase
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.validation import validate_fmu
from logged import Log, callbacks

every_fmu = pytest.mark.parametrize("name", NAMES)
STEP = 0.01


def simulate(path, stop_time, **options):
    log = Log()
    result = simulate_fmu(
        path, stop_time=stop_time, output_interval=STEP, record_events=False, logger=log, **options
    )
    assert log.complaints == []
    assert all(np.isfinite(result[column]).all() for column in result.dtype.names)
    return result


def everything(path):
    """Names of all variables that are numbers."""
    return [v.name for v in read_model_description(path).modelVariables if v.type != "String"]


@pytest.mark.judge("fmpy", "validation")
@every_fmu
def test_archive_and_description_are_valid(fmu, name):
    assert validate_fmu(fmu(name)) == []


@pytest.mark.judge("fmpy", "co-simulation, every variable recorded")
@every_fmu
def test_co_simulation_gives_every_variable(fmu, name):
    result = simulate(
        fmu(name), 5.0, output=everything(fmu(name)), fmi_type="CoSimulation",
        input=inputs(fmu(name), np.arange(501) * STEP),
    )
    assert len(result) == 501 and result["time"][-1] == pytest.approx(5.0)


@pytest.mark.judge("fmpy", "model exchange (CVODE), equal to co-simulation")
@every_fmu
def test_model_exchange_agrees_with_co_simulation(fmu, name):
    """For a minute with inputs that jump every second."""
    held, stairs = staircase(fmu(name), 60.0, STEP)
    cs = simulate(fmu(name), 60.0, fmi_type="CoSimulation", input=held)
    me = simulate(fmu(name), 60.0, fmi_type="ModelExchange", solver="CVode", input=stairs,
                  relative_tolerance=1e-11)
    assert len(cs) == len(me) and np.allclose(cs["time"], me["time"], rtol=0, atol=1e-9)
    # At a jump itself co-simulation shows outputs from before it, model exchange from after it.
    compared = ~np.isin(np.round(cs["time"] / STEP), np.round(stairs["time"][1:-1] / STEP))
    for output in cs.dtype.names[1:]:
        difference, peak = np.abs(cs[output] - me[output])[compared], np.max(np.abs(cs[output]))
        # Values that are zero except for rounding are equal.
        assert np.max(difference) <= 1e-6 * peak + 1e-15, output


class Stepped:
    """A co-simulation instance with varying inputs, and all its outputs."""

    def __init__(self, path, folder):
        description = read_model_description(path)
        self.fmu = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="judged",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.log = Log()
        self.filter = description.modelName.startswith(("Ekf", "Nav"))
        self.fmu.instantiate(callbacks=callbacks(self.log))
        self.outputs = [v.valueReference for v in description.modelVariables
                        if v.causality == "output"]
        self.signals = inputs(path, np.arange(400) * STEP)
        references = {v.name: v.valueReference for v in description.modelVariables}
        self.inputs = [references[name] for name in self.signals.dtype.names[1:]]

    def start(self):
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def run(self, first, steps):
        """The outputs after each step."""
        rows = []
        for step in range(first, first + steps):
            self.fmu.setReal(self.inputs, list(self.signals[step])[1:])
            self.fmu.doStep(currentCommunicationPoint=step * STEP, communicationStepSize=STEP)
            rows.append(self.fmu.getReal(self.outputs))
        return rows

    def end(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        # Strings arrive as the format that they fill: "%s" may be the health of a filter, or a complaint.
        allowed = {"%s"} if self.filter else set()
        assert set(self.log.complaints) <= allowed


@pytest.mark.judge("fmpy", "get, set, serialize state")
@every_fmu
def test_a_state_goes_on_bit_for_bit_in_another_instance(fmu, name, tmp_path):
    folder = extract(fmu(name), tmp_path)
    one, other = (Stepped(fmu(name), folder) for _ in range(2))
    one.start()
    one.run(0, 137)
    state = one.fmu.getFMUstate()
    serialized = one.fmu.serializeFMUstate(state)
    expected = one.run(137, 200)

    one.fmu.setFMUstate(state)
    assert one.run(137, 200) == expected
    one.fmu.freeFMUstate(state)

    other.start()
    restored = other.fmu.deSerializeFMUstate(serialized)
    other.fmu.setFMUstate(restored)
    assert other.run(137, 200) == expected
    other.fmu.freeFMUstate(restored)
    one.end()
    other.end()


@pytest.mark.judge("fmpy", "directional derivatives")
@every_fmu
def test_directional_derivatives_are_those_of_the_functions(fmu, name, tmp_path):
    """Compared with central differences through the same interface; if not declared, they are rejected."""
    description = read_model_description(fmu(name))
    model = FMU2Model(
        guid=description.guid, unzipDirectory=extract(fmu(name), tmp_path), instanceName="judged",
        modelIdentifier=description.modelExchange.modelIdentifier,
    )
    log = Log()
    model.instantiate(callbacks=callbacks(log))
    model.setupExperiment(startTime=0.0)
    model.enterInitializationMode()
    model.exitInitializationMode()
    model.enterContinuousTimeMode()
    references = {v.name: v.valueReference for v in description.modelVariables}
    signals = inputs(fmu(name), [1.0])
    knowns = [references[v] for v in signals.dtype.names[1:]]
    unknowns = [v.variable.valueReference for v in description.outputs]
    point = list(signals[0])[1:]
    model.setReal(knowns, point)
    if not description.modelExchange.providesDirectionalDerivative:
        with pytest.raises(Exception, match="[Dd]irectional"):
            model.getDirectionalDerivative(unknowns, knowns[:1], [1.0])
        assert len(log.complaints) == 1
        model.getReal(unknowns)  # The instance lives.
    else:
        for column, (known, value) in enumerate(zip(knowns, point)):
            found = np.array(model.getDirectionalDerivative(unknowns, [known], [1.0]))
            step = 1e-3 * max(1.0, abs(value))
            moved = []
            for sign in (1.0, -1.0):
                model.setReal([known], [value + sign * step])
                moved.append(np.array(model.getReal(unknowns)))
            model.setReal([known], [value])
            expected = (moved[0] - moved[1]) / (2.0 * step)
            scale = max(np.max(np.abs(expected)), 1e-6)
            assert np.allclose(found, expected, rtol=1e-6, atol=1e-6 * scale), column
        assert log.complaints == []
    model.terminate()
    model.freeInstance()
