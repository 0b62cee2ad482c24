"""The same work in FilterPy: the mean time of a prediction with its updates.

`usual` is an inertial filter of 16 states as a user of FilterPy writes it, with its models in NumPy and sensors at
their usual rates; `all` has an update of every sensor at each prediction. A number is an EKF with that many states of
which F and the Jacobians cost nothing: a prediction, and updates of 2, 1, 1, 3 and 2 components.

pip install numpy scipy filterpy; python xtask/bench/filterpy_ekf.py [usual|all|STATES ...]
"""

import sys
import time
from math import cos, pi, sin

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

ROUNDS = 101
GRAVITY, IDENTITY = np.array([0.0, 0.0, 9.81]), np.eye(3)
P, U, EULER, B_A, B_G, BIAS = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12), slice(12, 15), 15
DVL, PRESSURE = np.array([-1.4, 0.0, 0.312]), np.array([-1.32, -0.5, -0.85])


def skew(a):
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def rotation(euler):
    (sr, sp, sy), (cr, cp, cy) = map(sin, euler), map(cos, euler)
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def rates(euler):
    """The matrices from body rates to the rates of the angles, and back."""
    sr, cr, sp, cp = sin(euler[0]), cos(euler[0]), sin(euler[1]), cos(euler[1])
    there = np.array([[1.0, sr * sp / cp, cr * sp / cp], [0.0, cr, -sr], [0.0, sr / cp, cr / cp]])
    return there, np.array([[1.0, 0.0, -sp], [0.0, cr, sr * cp], [0.0, -sr, cr * cp]])


class Inertial(ExtendedKalmanFilter):
    """Position, velocity along body axes, angles, biases of accelerometers, gyros and compass."""

    def __init__(self):
        super().__init__(dim_x=16, dim_z=3)
        self.x = np.zeros(16)
        self.P = np.diag([0.5] * 3 + [0.1] * 3 + [0.02] * 3 + [0.03] * 3 + [0.001] * 3 + [0.02]) ** 2
        self.Q = np.diag([1e-9] * 3 + [1e-6] * 3 + [1e-8] * 3 + [1e-9] * 3 + [1e-12] * 3 + [0.0])

    def predict_x(self, u=0):
        force, rate, dt = u
        x = self.x
        f, w = force - x[B_A], rate - x[B_G]
        r, (there, back), velocity = rotation(x[EULER]), rates(x[EULER]), x[U].copy()
        down, by_rate = r.T @ GRAVITY, skew(velocity)
        F = np.eye(16)
        F[P, U] = r * dt
        F[P, EULER] = r @ by_rate @ back * -dt
        F[U, U] -= skew(w) * dt
        F[U, EULER] = skew(down) @ back * dt
        F[U, B_A] = IDENTITY * -dt
        F[U, B_G] = by_rate * -dt
        F[EULER, B_G] = there * -dt
        self.F = F
        x[P] += r @ velocity * dt
        x[U] += (f + down + by_rate @ w) * dt
        x[EULER] += there @ w * dt
        self.rate = w


def select(state, size):
    rows = np.zeros((size, 16))
    rows[:, state] = np.eye(size)
    return rows


def wrapped(a, b):
    return (a - b + pi) % (2.0 * pi) - pi


ATTITUDE, FIX, DEPTH, VELOCITY = select(EULER, 3), select(slice(0, 2), 2), select(slice(2, 3), 1), select(U, 3)
ATTITUDE[2, BIAS] = 1.0
VELOCITY[:, B_G] = skew(DVL)


def by_depth(x):
    row = DEPTH.copy()
    row[0, EULER] = rotation(x[EULER])[2] @ -skew(PRESSURE) @ rates(x[EULER])[1]
    return row


def sensors(ekf):
    """Value, Jacobian, prediction, residual and noise of attitude, depth, velocity log and fix."""
    arm = -skew(DVL)
    return [
        (np.zeros(3), lambda x: ATTITUDE, lambda x: ATTITUDE @ x, wrapped, np.eye(3) * 1e-4),
        (np.zeros(1), by_depth, lambda x: x[2:3] + rotation(x[EULER])[2] @ PRESSURE, np.subtract, np.eye(1) * 0.09),
        (np.array([0.5, 0.0, 0.0]), lambda x: VELOCITY, lambda x: x[U] + arm @ ekf.rate, np.subtract, np.eye(3) * 1e-4),
        (np.zeros(2), lambda x: FIX, lambda x: FIX @ x, np.subtract, np.eye(2) * 0.25),
    ]


def inertial(every):
    """A second of sensors, each of which measures at every so-manieth prediction."""
    ekf = Inertial()
    measured = list(zip(sensors(ekf), every))
    force, rate = np.array([0.0, 0.0, -9.81]), np.zeros(3)

    def second():
        for k in range(50):
            ekf.predict((force, rate, 0.02))
            for (value, jacobian, predicted, residual, noise), period in measured:
                if k % period == 0:
                    ekf.update(value, jacobian, predicted, R=noise, residual=residual)

    return second, 50


def algebra(states):
    ekf = ExtendedKalmanFilter(dim_x=states, dim_z=3)
    ekf.F = np.eye(states) + 1e-3 * np.random.default_rng(1).standard_normal((states, states))
    ekf.Q = 1e-3 * np.eye(states)
    fused = []
    for size in (2, 1, 1, 3, 2):
        rows = np.eye(size, states)
        fused.append((np.zeros((size, 1)), lambda _, h=rows: h, lambda x, h=rows: h @ x, np.eye(size)))

    def cycles():
        for _ in range(5):
            ekf.predict()
            for measured, jacobian, predicted, noise in fused:
                ekf.update(measured, jacobian, predicted, R=noise)

    return cycles, 5


def main():
    for what in sys.argv[1:] or ["usual", "all", "16", "30"]:
        rates = {"usual": (1, 5, 7, 50), "all": (1, 1, 1, 1)}.get(what)
        (work, predictions), rounds = inertial(rates) if rates else algebra(int(what)), []
        for _ in range(ROUNDS):
            begun = time.perf_counter()
            work()
            rounds.append((time.perf_counter() - begun) / predictions)
        print(f"{what}: median {1e6 * sorted(rounds)[ROUNDS // 2]:.0f} us")


main()
