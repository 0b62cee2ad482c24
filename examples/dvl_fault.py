"""What does a fault of the velocity log do to either filter? One scenario, two runs, a table and a page.

    pip install rexrov
    python dvl_fault.py          # writes dvl_fault.html
"""

from pathlib import Path

import numpy as np
import rexrov

SCENARIO = Path(__file__).with_suffix(".json")
PHASES = {
    "before": (0, 60),
    "silent": (60, 90),
    "good again": (90, 150),
    "biased": (150, 180),
    "good at the end": (180, 240),
}

errors, page = {}, {}
for name in ("EkfDynamic", "EkfKinematic"):
    loop = rexrov.run(
        rexrov.system_path("paper"),
        replace={"ekf": rexrov.fmu_path(name)},
        start_values={"pursuit.course": "BE3"},
        scenario=SCENARIO,
        stop_time=240,
        output_interval=0.1,
    )
    time = page["time"] = loop["time"]
    errors[name] = np.hypot(*(loop[f"ekf.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"))
    page |= {f"{name}.error": errors[name], f"{name}.x": loop["ekf.pose.x"], f"{name}.y": loop["ekf.pose.y"]}
    page |= {f"{name}.true_x": loop["vehicle.pose.x"], f"{name}.true_y": loop["vehicle.pose.y"]}

print(f"{'horizontal error, m (RMS)':26}", *(f"{name:>12}" for name in errors))
rms = {}
for phase, (begin, end) in PHASES.items():
    during = (time >= begin) & (time < end)
    rms[phase] = [np.sqrt(np.mean(error[during] ** 2)) for error in errors.values()]
    print(f"{phase:26}", *(f"{value:12.2f}" for value in rms[phase]))
assert rms["silent"] > rms["before"] and rms["biased"][0] > rms["before"][0], "the faults show"

table = np.rec.fromarrays(list(page.values()), names=list(page))
paths = {f"Path with {name}": [(f"{name}.true_x", f"{name}.true_y"), (f"{name}.x", f"{name}.y")] for name in errors}
plots = {"Horizontal error, m": [f"{name}.error" for name in errors]}
written = rexrov.report(table, "dvl_fault.html", title="Faults of the DVL", plots=plots, paths=paths)
print(f"the report is in {written}")
