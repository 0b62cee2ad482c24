"""The same chain in libcosim and in a loop over FMPy's instances.

usage: chain.py FMU FOLDER LENGTH STEPS; prints nanoseconds of processor time per FMU-step of either.
FOLDER holds the unpacked FMU.
"""

import sys
import time

from fmpy import read_model_description
from fmpy.fmi2 import FMU2Slave
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimSlave import CosimLocalSlave

U, Y = 0, 2
STEP = 1e-3


def libcosim(fmu, length, steps):
    log_output_level(CosimLogLevel.FATAL)
    execution = CosimExecution.from_step_size(round(STEP * 1e9))
    slaves = [CosimLocalSlave(fmu, f"g{position}") for position in range(length)]
    indices = [execution.add_local_slave(slave) for slave in slaves]
    for source, sink in zip(indices, indices[1:]):
        execution.connect_real_variables(source, Y, sink, U)
    assert execution.step(1)  # Initializes.
    begun = time.process_time_ns()
    assert execution.step(steps)
    return (time.process_time_ns() - begun) / steps / length


def fmpy_loop(folder, length, steps):
    description = read_model_description(folder)
    chain = []
    for position in range(length):
        fmu = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, instanceName=f"g{position}",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        fmu.instantiate()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        chain.append(fmu)
    value = [1.0]
    begun = time.process_time_ns()
    for step in range(steps):
        for fmu in chain:
            fmu.setReal([U], value)
            fmu.doStep(currentCommunicationPoint=step * STEP, communicationStepSize=STEP)
            value = fmu.getReal([Y])
    return (time.process_time_ns() - begun) / steps / length


if __name__ == "__main__":
    fmu, folder, length, steps = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    print(libcosim(fmu, length, steps), fmpy_loop(folder, length, steps))
