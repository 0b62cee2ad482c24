"""Co-simulation compared with model exchange solved by CVODE, over a minute of driven motion: both interfaces of
every component agree within a millionth of each signal's peak.

This compares one description of a component with two integrators, so both must see the same
inputs. FMPy interpolates inputs linearly between the rows of an array, but

* in co-simulation it sets the derivatives of exactly nine inputs (fmpy.simulation.Input allocates nine),
  and at the corner of a polygon those of the segment that ends there,
* in model exchange the right-hand side sees the inputs of the last call of the event indicators.

`follow` fixes that, so that the inputs are polygons for both interfaces; without it the inputs are stairs
whose jumps FMPy takes for events.
"""

import fmpy.simulation
import fmpy.sundials
import numpy as np
import pytest
from conftest import NAMES
from fmpy import read_model_description, simulate_fmu

STOP = 60.0
# Communication step, and the length of the segments of the inputs (s).
STEP = 0.1
LIMIT = 1e-6

FORCE_WITH_LAG, FORCE, ROTOR_SPEED = 1, 2, 3
DORMAND_PRINCE = 2
# Far below the required accuracy, because CVODE's tolerance is per step, not for the run.
CVODE_TOLERANCE = 1e-10

# Default settings: steps short enough for the lag of the rotors after commands that jump.
DEFAULT = {}
# An adaptive integrator adapts its steps at limits and reversals as well; the tolerance is per step.
ADAPTIVE = {"integrator.method": DORMAND_PRINCE, "integrator.tolerance": 1e-10}


class PolygonInput(fmpy.simulation.Input):
    """FMPy's inputs with as many derivatives as there are inputs, those of the next segment."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        if self.t is not None:
            self.continuous = [
                c._replace(derivatives=(c.values._type_ * len(c.vrs))()) for c in self.continuous
            ]

    @staticmethod
    def interpolate(time, t, table, discrete=False, after_event=False):
        # A corner that rounding puts just ahead has been reached.
        left = np.clip(np.searchsorted(t, time + 1e-9, side="right") - 1, 0, len(t) - 2)
        slope = (table[:, left + 1] - table[:, left]) / (t[left + 1] - t[left])
        return table[:, left] + slope * (time - t[left]), slope


class FollowingCVode(fmpy.sundials.CVodeSolver):
    """FMPy's CVODE with the inputs at the time at which the right-hand side is evaluated."""

    def f(self, t, y, ydot, user_data):
        self.input.apply(t)
        return super().f(t, y, ydot, user_data)


@pytest.fixture
def follow(monkeypatch):
    monkeypatch.setattr(fmpy.simulation, "Input", PolygonInput)
    monkeypatch.setattr(fmpy.sundials, "CVodeSolver", FollowingCVode)


def table(times, signals):
    array = np.zeros(len(times), dtype=[("time", float)] + [(name, float) for name in signals])
    array["time"] = times
    for name, values in signals.items():
        array[name] = values
    return array


def polygon(signals):
    """Functions of time, sampled at the ends of the communication steps."""
    times = np.arange(round(STOP / STEP) + 1) * STEP
    return table(times, {name: signal(times) for name, signal in signals.items()})


def stairs(signals):
    """The same with a jump every half second, between the sample instants of all components: a sample at
    the end of a co-simulation step has the inputs of the step, in model exchange those after the jump."""
    jumps = np.arange(0.45, STOP, 0.5)
    times = np.concatenate([[0.0], np.repeat(jumps, 2), [STOP]])
    values = {name: np.repeat(signal(np.append(0.0, jumps)), 2) for name, signal in signals.items()}
    return table(times, values)


def compare(fmu, name, inputs, start=None, derivatives=True):
    options = {
        "stop_time": STOP,
        "output_interval": STEP,
        "start_values": start or {},
        "input": inputs,
        "record_events": False,
    }
    path = fmu(name)
    me = simulate_fmu(
        path, fmi_type="ModelExchange", relative_tolerance=CVODE_TOLERANCE, **options
    )
    cs = simulate_fmu(path, fmi_type="CoSimulation", set_input_derivatives=derivatives, **options)
    points = np.arange(round(STOP / STEP) + 1) * STEP
    cs, me = (run[np.searchsorted(run["time"], points - 1e-6)] for run in (cs, me))
    assert np.allclose(cs["time"], points) and np.allclose(me["time"], points)
    worst = {}
    for signal in cs.dtype.names[1:]:
        peak = np.max(np.abs(me[signal]))
        worst[signal] = np.max(np.abs(cs[signal] - me[signal])) / (peak or 1.0)
    print(name, "worst:", max(worst.items(), key=lambda item: item[1]))
    assert {signal: error for signal, error in worst.items() if not error <= LIMIT} == {}
    # A constant signal would agree whatever the interfaces do.
    assert any(np.ptp(cs[signal]) > 0.0 for signal in worst)


def wave(mean, amplitude, period, phase=0.0):
    return lambda t: mean + amplitude * np.sin(2.0 * np.pi * t / period + phase)


# No thruster reverses and none saturates; vertical and horizontal ones, a wrench and a current.
SMOOTH = {
    "thruster[0].force": wave(300.0, 120.0, 17.0),
    "thruster[3].force": wave(260.0, 150.0, 23.0, 1.0),
    "thruster[4].force": wave(220.0, 100.0, 31.0),
    "thruster[6].force": wave(-240.0, 90.0, 29.0, 2.0),
    "wrench.M": wave(0.0, 60.0, 13.0),
    "wrench.N": wave(5.0, 40.0, 19.0),
    "current.north": wave(0.2, 0.1, 41.0),
    "current.east": wave(-0.1, 0.1, 37.0, 0.5),
    "current.down": wave(0.0, 0.05, 43.0),
}


@pytest.mark.parametrize("integrator", [DEFAULT, ADAPTIVE], ids=["default", "adaptive"])
def test_vehicle_along_smooth_inputs(fmu, follow, integrator):
    compare(fmu, "RexROV", polygon(SMOOTH), integrator)


@pytest.mark.parametrize("mode", [FORCE_WITH_LAG, FORCE], ids=["with lag", "at once"])
def test_vehicle_with_thrusts_beyond_their_limits_and_through_zero(fmu, follow, mode):
    """Each crossing is a state event for both."""
    saturating = SMOOTH | {
        "thruster[4].force": wave(0.0, 3000.0, 21.0),
        "thruster[5].force": wave(0.0, -2600.0, 17.0),
        "thruster[6].force": wave(200.0, 2400.0, 26.0, 0.3),
    }
    compare(fmu, "RexROV", polygon(saturating), ADAPTIVE | {"thruster_mode": mode})


def test_vehicle_with_rotor_speeds_beyond_their_limit(fmu, follow):
    speeds = {f"thruster[{i}].speed": wave(0.0, 3200.0, 15.0 + 2.0 * i, 0.4 * i) for i in (4, 5, 6, 7)}
    compare(fmu, "RexROV", polygon(speeds), {"thruster_mode": ROTOR_SPEED})


@pytest.mark.parametrize("integrator", [DEFAULT, ADAPTIVE], ids=["default", "adaptive"])
def test_vehicle_with_inputs_that_jump(fmu, integrator):
    """Like an importer without derivatives, with FMPy unmodified."""
    compare(fmu, "RexROV", stairs(SMOOTH), integrator, derivatives=False)


def driven(fmu, name):
    """A wave on each input that is a measured quantity; sample times and flags keep their start values,
    as in an importer that connects nothing to them."""
    signals = {}
    for variable in read_model_description(fmu(name)).modelVariables:
        flag = variable.name.endswith(("stamp", "valid", "off"))
        if variable.causality != "input" or flag:
            continue
        number = len(signals)
        amplitude = 0.2 * float(variable.nominal or 1.0)
        period = 11.0 + 3.0 * number
        signals[variable.name] = wave(float(variable.start), amplitude, period, float(number))
    return signals


# The course of the guidance starts at the origin, 20 m deep, and leads north.
ALONG_THE_COURSE = {
    "pose.x": lambda t: 0.3 * t,
    "pose.y": wave(0.0, 0.8, 25.0),
    "pose.z": wave(20.0, 0.3, 33.0),
    "pose.yaw": wave(0.0, 0.3, 21.0),
}
SAMPLED = [name for name in NAMES if name != "RexROV"]


@pytest.mark.parametrize("name", SAMPLED)
def test_sampled_component_along_polygons(fmu, follow, name):
    """It samples between the ends of the steps, where the inputs of both interfaces are interpolated."""
    signals = ALONG_THE_COURSE if name == "PurePursuit" else driven(fmu, name)
    compare(fmu, name, polygon(signals))


@pytest.mark.parametrize("name", SAMPLED)
def test_sampled_component_with_inputs_that_jump(fmu, name):
    signals = ALONG_THE_COURSE if name == "PurePursuit" else driven(fmu, name)
    compare(fmu, name, stairs(signals), derivatives=False)
