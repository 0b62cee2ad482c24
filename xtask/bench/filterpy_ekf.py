"""The same work in FilterPy, with Jacobians at no cost: a prediction, and updates of 2, 1, 1, 3 and 2 components.

pip install numpy scipy filterpy; python xtask/bench/filterpy_ekf.py [STATES ...]
"""

import sys
import time

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

ROUNDS, TIMES = 201, 5


def cycle_of(states):
    ekf = ExtendedKalmanFilter(dim_x=states, dim_z=3)
    ekf.F = np.eye(states) + 1e-3 * np.random.default_rng(1).standard_normal((states, states))
    ekf.Q = 1e-3 * np.eye(states)
    sensors = []
    for size in (2, 1, 1, 3, 2):
        rows = np.eye(size, states)
        sensors.append((np.zeros((size, 1)), lambda _, h=rows: h, lambda x, h=rows: h @ x, np.eye(size)))

    def cycle():
        ekf.predict()
        for measured, jacobian, predicted, noise in sensors:
            ekf.update(measured, jacobian, predicted, R=noise)

    return cycle


def main():
    for states in map(int, sys.argv[1:] or ["16", "30"]):
        cycle, rounds = cycle_of(states), []
        for _ in range(ROUNDS):
            begun = time.perf_counter()
            for _ in range(TIMES):
                cycle()
            rounds.append((time.perf_counter() - begun) / TIMES)
        print(f"{states} states: median {1e6 * sorted(rounds)[ROUNDS // 2]:.0f} us")


main()
