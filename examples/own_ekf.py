"""How do I put my own filter into the loop? Write it in Python, make it an FMU, name it.

    pip install rexrov pythonfmu
    python own_ekf.py

PythonFMU turns the class below into OwnEkf.fmu. It has the ports of EkfDynamic and EkfKinematic, so it
takes the place of either; what it does inside is its own business. Same courses, noise and seeds for all.
"""

from math import cos, sin, tau

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

SENSORS = ("imu", "ahrs", "dvl", "fix", "pressure", "propulsion")
AXES = ("x", "y", "z", "yaw")
INPUTS = {
    **{f"imu.{name}": 0.0 for name in ("specific_force.x", "specific_force.y", "specific_force.z")},
    **{f"imu.{name}": 0.0 for name in ("rate.p", "rate.q", "rate.r")},
    **{f"ahrs.attitude.{name}": 0.0 for name in ("roll", "pitch", "yaw")},
    **{f"dvl.velocity.{name}": 0.0 for name in "uvw"},
    **{f"fix.position.{name}": 0.0 for name in "xy"},
    "pressure.depth": 0.0,
    **{f"{sensor}.stamp": -1.0 for sensor in SENSORS},
    **{f"{sensor}.valid": 0.0 for sensor in SENSORS},
    **{f"thruster[{i}].thrust": 0.0 for i in range(8)},
}
OUTPUTS = {f"{group}.{axis}": 0.0 for group in ("pose", "sigma") for axis in AXES}
PARAMETERS = {"fix_sigma": 1.5}
# Where the sensors are, body frame (m).
DVL, PRESSURE = np.array([-1.4, 0.0, 0.312]), np.array([-1.32, -0.5, -0.85])


class OwnEkf(Fmi2Slave):
    """State: north, east, down (m) and yaw (rad); driven by DVL and gyro, corrected by the rest."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.values = {**INPUTS, **OUTPUTS, **PARAMETERS}
        for name in INPUTS:
            self.add(name, causality=Fmi2Causality.input)
        for name in OUTPUTS:
            self.add(name, causality=Fmi2Causality.output)
        for name in PARAMETERS:
            self.add(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)
        self.state = np.array([0.0, 0.0, 20.0, 0.0])
        self.covariance = np.diag([0.1, 0.1, 0.1, 0.01]) ** 2
        self.velocity = np.zeros(3)
        self.seen = dict.fromkeys(SENSORS, -1.0)

    def add(self, name, **how):
        def store(value):
            self.values[name] = value

        self.register_variable(Real(name, getter=lambda: self.values[name], setter=store, **how))

    def exit_initialization_mode(self):
        self.cycle(0.0)

    def do_step(self, current_time, step_size):
        self.cycle(step_size)
        return True

    def cycle(self, h):
        """Predicts by h seconds, then corrects with what is new."""
        u = self.values
        r = u["imu.rate.r"]
        if self.new("dvl"):
            measured = np.array([u[f"dvl.velocity.{name}"] for name in "uvw"])
            self.velocity = measured - np.cross([0.0, 0.0, r], DVL)
        psi = self.state[3] + 0.5 * h * r
        turn = np.array([[cos(psi), -sin(psi), 0.0], [sin(psi), cos(psi), 0.0], [0.0, 0.0, 1.0]])
        moved = turn @ self.velocity * h
        self.state += [*moved, r * h]
        # Jacobian of the motion: an error of yaw turns the way made.
        jacobian = np.eye(4)
        jacobian[:2, 3] = -moved[1], moved[0]
        self.covariance = jacobian @ self.covariance @ jacobian.T + h * np.diag([1e-5, 1e-5, 1e-4, 1e-4])
        if self.new("fix"):
            self.correct(0, u["fix.position.x"] - self.state[0], u["fix_sigma"])
            self.correct(1, u["fix.position.y"] - self.state[1], u["fix_sigma"])
        if self.new("pressure"):
            roll, pitch = u["ahrs.attitude.roll"], u["ahrs.attitude.pitch"]
            down = np.array([-sin(pitch), cos(pitch) * sin(roll), cos(pitch) * cos(roll)])
            self.correct(2, u["pressure.depth"] - down @ PRESSURE - self.state[2], 0.306)
        if self.new("ahrs"):
            off = u["ahrs.attitude.yaw"] - self.state[3]
            self.correct(3, (off + tau / 2) % tau - tau / 2, 0.01)
        for i, axis in enumerate(AXES):
            u[f"pose.{axis}"] = float(self.state[i])
            u[f"sigma.{axis}"] = float(self.covariance[i, i]) ** 0.5

    def new(self, sensor):
        """Whether there is a measurement that was not used yet."""
        stamp = self.values[f"{sensor}.stamp"]
        if self.values[f"{sensor}.valid"] < 0.5 or stamp == self.seen[sensor]:
            return False
        self.seen[sensor] = stamp
        return True

    def correct(self, i, innovation, sigma):
        """With a measurement of the state's element i."""
        gain = self.covariance[:, i] / (self.covariance[i, i] + sigma**2)
        self.state += gain * innovation
        self.covariance -= np.outer(gain, self.covariance[i])


if __name__ == "__main__":
    import rexrov
    from pythonfmu.builder import FmuBuilder

    own = FmuBuilder.build_FMU(__file__, dest=".")
    errors = {}
    for filter in (rexrov.fmu_path("EkfDynamic"), rexrov.fmu_path("EkfKinematic"), own):
        loop = rexrov.run(
            rexrov.system_path("paper"),
            replace={"ekf": filter},
            start_values={"pursuit.course": "BE3"},
            stop_time=330,
            output_interval=0.1,
            # PythonFMU says that its FMUs need Python; it is here.
            options=["--execution-tool"],
        )
        off = np.hypot(*(loop[f"ekf.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"))
        errors[filter.stem] = float(np.sqrt(np.mean(off**2)))
        print(f"{filter.stem:13} horizontal error {errors[filter.stem]:.3f} m (RMS)")
    assert errors["OwnEkf"] < errors["EkfKinematic"], "the Jacobian of the motion should do better"
