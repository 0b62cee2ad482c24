"""What does a fault of the velocity log do to each filter? One scenario, two runs, a table and a page.

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



def follow(filter, scenario):
    return rexrov.run(
        rexrov.system_path("paper"),
        replace={"ekf": rexrov.fmu_path(filter)},
        start_values={"pursuit.course": "BE3"},
        scenario=scenario,
        stop_time=240,
        output_interval=0.1,
    )


# Each filter without and with the faults; noise and seeds are the same.
errors, page, paths = {}, {}, {}
for filter in ("EkfDynamic", "EkfKinematic"):
    for name, scenario in ((filter, None), (f"{filter} faulty", SCENARIO)):
        loop = follow(filter, scenario)
        page["time"] = loop["time"]
        errors[name] = np.hypot(*(loop[f"ekf.pose.{axis}"] - loop[f"vehicle.pose.{axis}"] for axis in "xy"))
    page |= {f"{filter}.{axis}": loop[f"ekf.pose.{axis}"] for axis in "xy"}
    page |= {f"{filter}.true_{axis}": loop[f"vehicle.pose.{axis}"] for axis in "xy"}
    # East to the right, north up.
    paths[f"Path with {filter}, faulty"] = [(f"{filter}.{y}", f"{filter}.{x}") for y, x in (("true_y", "true_x"), "yx")]

print(f"{'horizontal error, m (RMS)':26}", *(f"{name:>19}" for name in errors))
rms = {}
for phase, (begin, end) in PHASES.items():
    during = (page["time"] >= begin) & (page["time"] < end)
    rms[phase] = [float(np.sqrt(np.mean(error[during] ** 2))) for error in errors.values()]
    print(f"{phase:26}", *(f"{value:19.2f}" for value in rms[phase]))

table = np.rec.fromarrays([*page.values(), *errors.values()], names=[*page, *errors])
plots = {f"Horizontal error with {filter}, m": [filter, f"{filter} faulty"] for filter in ("EkfDynamic", "EkfKinematic")}
written = rexrov.report(table, "dvl_fault.html", title="Faults of the DVL", plots=plots, paths=paths)
print(f"the report is in {written}")

for phase, harm in (("silent", 0.05), ("biased", 0.3)):
    assert rms[phase][1] > rms[phase][0] + harm, f"the dynamic filter suffers while the log is {phase}"
