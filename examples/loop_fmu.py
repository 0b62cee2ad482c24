"""How do I use the whole loop in my simulator? As one FMU, here in FMPy.

    pip install rexrov fmpy
    cosim export paper.ssd -o Loop.fmu      # paper.ssd: rexrov.system_path("paper")
    python loop_fmu.py Loop.fmu

The FMU has the components' parameters and outputs as `component.variable`, and contains the master.
"""

import sys

import numpy as np
from fmpy import simulate_fmu

for course in ("BE1", "BE2", "BE3"):
    loop = simulate_fmu(
        sys.argv[1],
        stop_time=100,
        output_interval=0.1,
        start_values={"pursuit.course": course, "gps.seed": 7},
        output=["vehicle.pose.x", "vehicle.pose.y", "ekf.pose.x", "ekf.pose.y", "pursuit.cross_track"],
    )
    error = np.hypot(*(loop[f"ekf.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"))
    print(f"{course}: at most {error.max():.2f} m between estimate and truth")
    assert error.max() < 5 and loop["vehicle.pose.x"].max() > 5
