"""Each sensor alone in FMPy."""

import numpy as np
import pytest
from fmpy import simulate_fmu

SENSORS = ["Imu", "Ahrs", "Dvl", "Gps", "PressureSensor", "Tachometer"]


def run(fmu, name, start_values, stop_time=60.0, output_interval=0.02, output=None):
    return simulate_fmu(
        fmu(name),
        start_values=start_values,
        stop_time=stop_time,
        step_size=output_interval,
        output_interval=output_interval,
        output=output,
    )


def test_accelerometer_at_rest_shows_gravity_with_noise(fmu):
    quiet = {"accelerometer.turn_on_sigma": 0.0, "accelerometer.random_walk": 0.0}
    result = run(fmu, "Imu", {"vehicle.specific_force.z": -9.81, **quiet})
    z = result["specific_force.z"]
    assert np.mean(z) == pytest.approx(-9.81, abs=0.003)
    assert np.std(z) == pytest.approx(0.004 * np.sqrt(50), rel=0.05)


def test_velocity_log_sees_its_lever_arm(fmu):
    result = run(fmu, "Dvl", {"vehicle.velocity.r": 0.1, "sigma": 0.0})
    assert result["velocity.v"][-1] == pytest.approx(-0.14)


def test_velocity_log_samples_seven_times_a_second(fmu):
    result = run(fmu, "Dvl", {}, stop_time=10.0, output_interval=0.01)
    instants = np.unique(result["stamp"])
    assert len(instants) == 71
    assert np.allclose(instants, np.arange(71) / 7.0, atol=1e-9)


def test_fix_has_the_noise_it_is_given(fmu):
    result = run(fmu, "Gps", {"vehicle.pose.x": 5.0, "sigma": 2.0, "rate_hz": 10.0},
                 stop_time=400.0, output_interval=0.1)
    assert np.mean(result["position.x"]) == pytest.approx(5.0, abs=0.15)
    assert np.std(result["position.x"]) == pytest.approx(2.0, rel=0.05)


def test_pressure_sensor_hangs_above_the_centre_of_gravity(fmu):
    result = run(fmu, "PressureSensor", {"vehicle.pose.z": 20.0, "sigma_pa": 0.0})
    assert result["depth"][-1] == pytest.approx(20.0 - 0.85)
    assert result["pressure"][-1] == pytest.approx(101325.0 + 9806.38 * 19.15)


@pytest.mark.parametrize("name", SENSORS)
def test_noise_is_repeated_by_its_seed_only(fmu, name):
    def noise(seed):
        result = run(fmu, name, {"seed": seed}, stop_time=2.0)
        return result.tobytes()

    assert noise(7) == noise(7)
    assert noise(7) != noise(8)


@pytest.mark.parametrize("name", SENSORS)
def test_a_sensor_switched_off_gives_no_sample(fmu, name):
    result = run(fmu, name, {"off": 1.0}, stop_time=2.0)
    assert not result["valid"].any()


def test_an_outage_does_not_change_the_noise_after_it(fmu):
    times = np.arange(0.0, 10.0, 0.1)
    signal = np.array(
        [(t, 1.0 if 2.0 <= t < 4.0 else 0.0) for t in times],
        dtype=[("time", float), ("off", float)],
    )

    def run_with(input):
        return simulate_fmu(fmu("Gps"), stop_time=10.0, step_size=0.1, output_interval=0.1,
                            input=input, output=["position.x", "stamp"])

    with_outage, without = run_with(signal), run_with(None)
    later = with_outage["time"] > 4.5
    assert np.array_equal(with_outage["position.x"][later], without["position.x"][later])
    during = (with_outage["time"] > 2.5) & (with_outage["time"] < 3.5)
    assert len(np.unique(with_outage["stamp"][during])) == 1


def test_a_fix_shows_after_its_latency_with_the_stamp_of_its_instant(fmu):
    result = run(fmu, "Gps", {"latency": 0.25}, stop_time=2.0, output_interval=0.01)
    shown = result["valid"] == 1.0
    age = result["time"][shown] - result["stamp"][shown]
    assert result["time"][shown][0] == pytest.approx(0.25)
    assert age.min() > 0.25 - 1e-6 and age.max() < 0.35
