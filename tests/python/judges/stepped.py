"""Steps one FMU with FMPy at given instants, as a separate process: third-party libraries may crash it.

`python stepped.py FMU STEP STOP VARIABLE...` reads the instants from standard input and writes the values of the
variables at each of them to standard output, all as JSON.
"""

import json
import sys

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


def values(fmu, times, step, names):
    """Rows of values, one for each instant."""
    described = read_model_description(fmu, validate=False)
    variables = {variable.name: variable for variable in described.modelVariables}
    experiment = described.defaultExperiment
    tolerance = experiment.tolerance if experiment else None
    slave = FMU2Slave(
        guid=described.guid,
        unzipDirectory=extract(fmu),
        modelIdentifier=described.coSimulation.modelIdentifier,
        instanceName="fmpy",
    )
    slave.instantiate()
    slave.setupExperiment(
        startTime=times[0], stopTime=times[-1], tolerance=float(tolerance) if tolerance else None
    )
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    read = {"Real": slave.getReal, "Integer": slave.getInteger, "Boolean": slave.getBoolean}
    read["Enumeration"] = slave.getInteger

    def row():
        ends = [(variables[name].type, variables[name].valueReference) for name in names]
        return [float(read[kind]([reference])[0]) for kind, reference in ends]

    rows = [row()]
    for time in times[:-1]:
        slave.doStep(currentCommunicationPoint=time, communicationStepSize=step)
        rows.append(row())
    return rows


if __name__ == "__main__":
    fmu, step, *names = sys.argv[1:]
    print(json.dumps(values(fmu, json.load(sys.stdin), float(step), names)))
