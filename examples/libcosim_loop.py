"""How do I run the loop in libcosim? Let cosim write an OSP folder, and open that.

    pip install rexrov libcosimpy
    cosim convert paper.ssd osp      # paper.ssd: rexrov.system_path("paper")
    python libcosim_loop.py osp

libcosim steps all components at once (Jacobi), so each connection is one step late: the trajectory is not
that of `cosim run`, but that of `cosim run --algorithm jacobi`.
"""

import sys

from libcosimpy.CosimEnums import CosimVariableCausality
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

SECONDS, STEP = 60, 0.02

execution = CosimExecution.from_osp_config_file(sys.argv[1])
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
slaves = {slave.name.decode(): slave.index for slave in execution.slave_infos()}
# Value references by the names of a component's outputs.
references = {
    slave: {
        variable.name.decode(): variable.reference
        for variable in execution.slave_variables(index)
        if variable.causality == CosimVariableCausality.OUTPUT.value
    }
    for slave, index in slaves.items()
}


def read(slave, *names):
    return observer.last_real_values(slaves[slave], [references[slave][name] for name in names])


print("time\tnorth\teast\testimated north\testimated east")
for second in range(0, SECONDS + 1, 5):
    assert second == 0 or execution.simulate_until(round(second * 1e9)), execution.status()
    if second:
        place = [*read("vehicle", "pose.x", "pose.y"), *read("ekf", "pose.x", "pose.y")]
        print(second, *(f"{value:.2f}" for value in place), sep="\t")
assert place[0] > 10, "the vehicle follows the course"
