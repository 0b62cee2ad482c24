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
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

# Its FMI Library reports an error for each FMU: it expects a start value of `time`, which FMI 2.0 forbids.
log_output_level(CosimLogLevel.FATAL)
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
for second in range(5, 65, 5):
    assert execution.simulate_until(second * 10**9), execution.status()
    place = [*read("vehicle", "pose.x", "pose.y"), *read("ekf", "pose.x", "pose.y")]
    print(second, *(f"{value:.2f}" for value in place), sep="\t")
assert place[0] > 10 and abs(place[0] - place[2]) < 5, "the vehicle follows the course"
