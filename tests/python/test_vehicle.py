"""RexROV alone in FMPy, compared with closed forms of its equations of motion."""

import numpy as np
import pytest
from fmpy import simulate_fmu

# Enumerations are set by number.
UUV, PAPER = 1, 3
FORCE_WITH_LAG, ROTOR_SPEED = 1, 3


def run(fmu, start_values=None, stop_time=60.0, output=None, **options):
    return simulate_fmu(
        fmu("RexROV"),
        start_values=start_values or {},
        stop_time=stop_time,
        output_interval=0.1,
        output=output or ["pose.z", "velocity.u", "velocity.w", "velocity.r"],
        **options,
    )


def terminal(force, linear, quadratic):
    """Speed at which linear plus quadratic damping balance a force."""
    return (np.sqrt(linear**2 + 4 * quadratic * force) - linear) / (2 * quadratic)


@pytest.mark.parametrize(
    "parameter_set, excess, linear, speed",
    [(UUV, 263.51, 728.4, 0.22977), (PAPER, 117.97, 782.4, 0.11824)],
)
def test_rises_at_the_speed_where_damping_balances_buoyancy(
    fmu, parameter_set, excess, linear, speed
):
    result = run(fmu, {"parameter_set": parameter_set})
    assert terminal(excess, linear, 1821.01) == pytest.approx(speed, abs=1e-5)
    assert -result["velocity.w"][-1] == pytest.approx(speed, abs=1e-4)


@pytest.mark.parametrize("mode, variable", [(FORCE_WITH_LAG, "force"), (ROTOR_SPEED, "speed")])
def test_surges_at_terminal_speed(fmu, mode, variable):
    # The wrench that the four horizontal thrusters give together; body axes, so no moment.
    force = 89.79 / (4 * np.cos(np.pi / 4))
    command = force if variable == "force" else np.sqrt(force / 0.00031)
    start = {f"thruster[{i}].{variable}": s * command for i, s in zip(range(4, 8), [1, 1, -1, -1])}
    # Neutrally buoyant, centred thrusters: only surge.
    start |= {f"thruster[{i}].lz": 0.0 for i in range(4, 8)}
    start |= {"parameter_set": PAPER, "buoyancy": 18276.03, "thruster_mode": mode}
    result = run(fmu, start, output=["velocity.u", "thruster[4].thrust"])
    assert result["thruster[4].thrust"][-1] == pytest.approx(force, rel=1e-9)
    assert result["velocity.u"][-1] == pytest.approx(0.3, abs=1e-3)


def test_drifts_with_the_current(fmu):
    result = run(fmu, {"current.north": 0.2, "current.east": -0.1, "buoyancy": 18274.7547},
                 stop_time=120.0, output=["velocity_ned.north", "velocity_ned.east"])
    assert result["velocity_ned.north"][-1] == pytest.approx(0.2, abs=0.01)
    assert result["velocity_ned.east"][-1] == pytest.approx(-0.1, abs=0.01)


def test_model_exchange_by_cvode_agrees_with_co_simulation(fmu):
    start = {"thruster[4].force": 200.0, "thruster[1].force": -150.0, "initial.attitude.roll": 0.2}
    outputs = ["pose.x", "pose.y", "pose.z", "pose.roll", "pose.yaw", "velocity.u", "velocity.r"]
    cs = run(fmu, start, 20.0, outputs, fmi_type="CoSimulation")
    me = run(fmu, start, 20.0, outputs, fmi_type="ModelExchange", relative_tolerance=1e-10)
    assert cs["time"][-1] == pytest.approx(me["time"][-1])
    for name in outputs:
        peak = float(np.max(np.abs(cs[name])))
        assert float(cs[name][-1]) == pytest.approx(float(me[name][-1]), abs=1e-6 * peak), name


def test_explicit_coefficients_win_over_the_named_set(fmu):
    light = run(fmu, {"parameter_set": PAPER, "mass": 1800.0})
    excess = 18393.9972 - 1800.0 * 9.81
    assert -light["velocity.w"][-1] == pytest.approx(terminal(excess, 782.4, 1821.01), abs=1e-4)


@pytest.mark.parametrize(
    "variable, value, reason",
    [("mass", -1.0, "mass"), ("mass", float("nan"), "mass"), ("volume", float("inf"), "volume")],
)
def test_impossible_parameters_are_refused_by_name(fmu, variable, value, reason):
    messages = []

    def logger(environment, instance, status, category, message):
        messages.append(message.decode())

    with pytest.raises(Exception):
        run(fmu, {variable: value}, logger=logger)
    assert len([m for m in messages if reason in m]) == 1, messages
