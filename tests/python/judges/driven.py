"""Varying inputs: a smooth signal for every input of an FMU, the same for all tools."""

import csv

import numpy as np
from fmpy import read_model_description

# Switches: inputs that an importer leaves alone when they are not connected.
HELD = "off"


def inputs(fmu, times):
    """A structured array with a column `time` and one per driven input, as FMPy expects it.

    A stamped quantity is measured at the time of its row.
    """
    driven = [
        variable
        for variable in read_model_description(fmu).modelVariables
        if variable.causality == "input" and not variable.name.endswith(HELD)
    ]
    signals = np.zeros(len(times), dtype=[("time", float)] + [(v.name, float) for v in driven])
    signals["time"] = times
    for number, variable in enumerate(driven):
        if variable.name.endswith("valid"):
            signals[variable.name] = 1.0
            continue
        if variable.name.endswith("stamp"):
            signals[variable.name] = times
            continue
        amplitude = 0.1 * float(variable.nominal or 1.0)
        wave = np.sin((0.3 + 0.05 * number) * np.asarray(times) + number)
        signals[variable.name] = float(variable.start) + amplitude * wave
    return signals


def staircase(fmu, stop_time, step):
    """The same input twice, constant except for a jump every second: for co-simulation one sample per step,
    for model exchange two samples at every jump, which FMPy takes for an event.

    The jumps are between the sample instants of all components, where the two interfaces see different
    inputs by definition: a sample at the end of a step still has the inputs of the step.
    """
    times = np.arange(round(stop_time / step) + 1) * step
    jumps = np.arange(37, len(times), 100)
    levels = inputs(fmu, np.append(0.0, times[jumps]))
    held = levels[np.searchsorted(jumps, np.arange(len(times)), side="right")]
    held["time"] = times
    stairs = np.repeat(levels, 2)
    stairs["time"] = np.concatenate([[0.0], np.repeat(times[jumps], 2), [stop_time]])
    return held, stairs


def write(signals, file):
    """The same as a CSV file, with every bit of every number."""
    with open(file, "w", newline="") as opened:
        writer = csv.writer(opened, lineterminator="\n")
        writer.writerow(signals.dtype.names)
        writer.writerows([[repr(float(value)) for value in row] for row in signals])
