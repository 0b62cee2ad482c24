"""The example of "Write your own component": an FMU written with the kit alone."""

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

NAME = "DepthHold"
MASS, DRAG, STIFFNESS, DAMPING = 26.0, 40.0, 100.0, 20.0
LIMIT = 60.0


def run(fmu, interface, target, **parameters):
    result = simulate_fmu(
        fmu(NAME),
        fmi_type=interface,
        stop_time=10,
        output_interval=0.1,
        relative_tolerance=1e-9,
        record_events=False,
        start_values={"target": target, **parameters},
        output=["depth"],
    )
    return result["time"], result["depth"]


def test_fmpy_finds_no_fault(fmu):
    assert validate_fmu(fmu(NAME)) == []
    description = read_model_description(fmu(NAME))
    assert description.coSimulation is not None
    assert description.modelExchange is not None
    assert description.numberOfEventIndicators == 1


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
def test_with_thrust_to_spare_it_is_a_damped_oscillator(fmu, interface):
    t, depth = run(fmu, interface, 3.0, limit=1e6)
    decay = (DRAG + DAMPING) / (2 * MASS)
    w = np.sqrt(STIFFNESS / MASS - decay**2)
    expected = 3 * (1 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
    np.testing.assert_allclose(depth, expected, atol=1e-6)


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
def test_at_full_thrust_it_approaches_its_terminal_velocity(fmu, interface):
    t, depth = run(fmu, interface, 100.0)
    lag = MASS / DRAG
    expected = LIMIT / DRAG * (t - lag * (1 - np.exp(-t / lag)))
    np.testing.assert_allclose(depth, expected, atol=1e-6)


def test_both_interfaces_agree_where_the_thruster_leaves_its_limit(fmu):
    _, inside = run(fmu, "CoSimulation", 5.0)
    _, outside = run(fmu, "ModelExchange", 5.0)
    assert 4.5 < inside[-1] < 5.5
    np.testing.assert_allclose(inside, outside, atol=1e-6)


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
def test_a_boolean_input_switches_it_off_and_a_boolean_output_tells_of_its_limit(fmu, interface):
    signals = np.array(
        [(0.0, 100.0, True), (2.0, 100.0, True), (2.0, 100.0, False), (4.0, 100.0, False)],
        dtype=[("time", float), ("target", float), ("on", bool)],
    )
    result = simulate_fmu(
        fmu(NAME), fmi_type=interface, stop_time=4, output_interval=0.1, relative_tolerance=1e-9, record_events=False,
        input=signals, output=["depth", "limited"],
    )
    t, limited = result["time"], result["limited"]
    assert limited.dtype == bool and limited[t < 1.95].all() and not limited[t > 2.15].any()
    # Without thrust it glides on until its drag has stopped it.
    lag = MASS / DRAG
    speed = LIMIT / DRAG * (1 - np.exp(-2 / lag))
    before = result["depth"][np.searchsorted(t, 2.0)]
    assert before < result["depth"][-1] < before + speed * (lag + 0.2)


def test_a_tunable_parameter_changes_while_it_runs(fmu):
    from fmpy import extract
    from fmpy.fmi2 import FMU2Slave

    description = read_model_description(fmu(NAME))
    variables = {v.name: v for v in description.modelVariables}
    assert variables["limit"].variability == "tunable"
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=extract(fmu(NAME)),
        modelIdentifier=description.coSimulation.modelIdentifier, instanceName="it",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal([variables["target"].valueReference], [100.0])
    slave.exitInitializationMode()

    def velocity(t):
        slave.doStep(currentCommunicationPoint=t, communicationStepSize=30.0)
        return slave.getReal([variables["w"].valueReference])[0]

    # Its terminal velocity is the limit over the drag.
    slave.setReal([variables["limit"].valueReference], [4.0])
    assert velocity(0.0) == pytest.approx(4.0 / DRAG, rel=1e-6)
    slave.setReal([variables["limit"].valueReference], [8.0])
    assert velocity(30.0) == pytest.approx(8.0 / DRAG, rel=1e-6)
    slave.terminate()
    slave.freeInstance()
