"""How do I evaluate my own filter? FilterPy's EKF in a campaign, beside ours: pip install rexrov filterpy"""

from pathlib import Path

import numpy as np
import rexrov
from filterpy.kalman import ExtendedKalmanFilter


class OwnEkf(ExtendedKalmanFilter):
    """North, east (m) and yaw (rad): driven by velocity log and gyro, corrected by fixes and compass."""

    rate = 10.0
    inputs = {"imu.rate.r": "rad/s", "dvl.velocity.{u,v}": "m/s", "fix.position.{x,y}": "m", "pressure.depth": "m"}
    inputs |= {"ahrs.attitude.yaw": "rad", "{ahrs,fix}.stamp": "s", "{ahrs,fix}.valid": "1"}
    outputs = {"pose.{x,y,z}": "m", "pose.yaw": "rad"}

    def __init__(self, fix_sigma=1.5):
        super().__init__(3, 1)
        self.x, self.P, self.R_fix, self.t = np.zeros(3), np.diag([0.01, 0.01, 1e-4]), np.eye(2) * fix_sigma**2, 0.0

    def predict_x(self, u=0):
        self.x = self.x + u

    def step(self, t, y):
        h, self.t, (u, v), r = t - self.t, t, y["dvl.velocity"], y["imu.rate.r"]
        v, c, s = v + 1.4 * r, np.cos(self.x[2] + r * h / 2), np.sin(self.x[2] + r * h / 2)  # it is 1.4 m astern
        self.F[:2, 2], self.Q = [h * (-s * u - c * v), h * (c * u - s * v)], h * np.diag([1e-5, 1e-5, 1e-4])
        self.predict(h * np.array([c * u - s * v, s * u + c * v, r]))
        if y.new("fix"):
            self.update(y["fix.position"], lambda x: np.eye(2, 3), lambda x: x[:2], self.R_fix)
        if y.new("ahrs"):
            turned = self.x[2] + (y["ahrs.attitude.yaw"] - self.x[2] + np.pi) % (2 * np.pi) - np.pi
            self.update(np.array([turned]), lambda x: np.eye(3)[2:], lambda x: x[2:], np.eye(1) * 1e-4)
        return {"pose": [self.x[0], self.x[1], y["pressure.depth"] + 0.85, self.x[2]]}


if __name__ == "__main__":
    rexrov.component(OwnEkf)
    Path("own_ekf.toml").write_text(f"""seeds = 20\nstop-time = 120\noutput-interval = 0.5
        systems.paper = "{rexrov.system_path("paper")}"\nreplacements = {{ dynamic = {{}}, own = {{ ekf = "OwnEkf.fmu" }} }}
        figures.ate = {{ kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose" }}
        verdict = [{{ figure = "ate", at-most = 1.0 }}]""")
    for verdict in rexrov.campaign("own_ekf.toml").summary["verdicts"]:
        print(verdict["cell"], verdict["threshold"], verdict["answer"], verdict["quantile"])
