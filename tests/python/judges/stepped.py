"""Steps one FMU with FMPy at given instants, as a separate process: third-party libraries may crash it.

`python stepped.py cs|me FMU STEP VARIABLE...` reads the instants from standard input and writes the values of the
variables at each of them to standard output, all as JSON. In model exchange each step is one of the classical Runge-Kutta
method, divided at events; those of the state are located by bisection.
"""

import ctypes
import json
import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave

# Two instants closer than this are the same (s).
SAME = 0.5e-9
# How exactly events of the state are located (s).
LOCATED = 1e-11


class Stepped:
    """A co-simulation FMU."""

    def __init__(self, fmu, start, stop):
        described = read_model_description(fmu, validate=False)
        self.described, self.variables = described, {v.name: v for v in described.modelVariables}
        experiment = described.defaultExperiment
        tolerance = experiment.tolerance if experiment else None
        kind, interface = self.interface(described)
        self.fmu = kind(
            guid=described.guid, unzipDirectory=extract(fmu), modelIdentifier=interface.modelIdentifier, instanceName="fmpy"
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=start, stopTime=stop, tolerance=float(tolerance) if tolerance else None)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def interface(self, described):
        return FMU2Slave, described.coSimulation

    def row(self, names):
        read = {"Real": self.fmu.getReal, "Integer": self.fmu.getInteger, "Boolean": self.fmu.getBoolean}
        read["Enumeration"] = self.fmu.getInteger
        ends = [(self.variables[name].type, self.variables[name].valueReference) for name in names]
        return [float(read[kind]([reference])[0]) for kind, reference in ends]

    def step(self, time, step):
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=step)


class Integrated(Stepped):
    """A model exchange FMU."""

    def __init__(self, fmu, start, stop):
        super().__init__(fmu, start, stop)
        self.x = np.zeros(self.described.numberOfContinuousStates)
        self.update()

    def interface(self, described):
        return FMU2Model, described.modelExchange

    @staticmethod
    def pointer(values):
        return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def update(self):
        """Ends event mode."""
        for _ in range(100):
            needed, terminate, _, _, next_defined, next_time = self.fmu.newDiscreteStates()
            assert not terminate, "it ends the run"
            if not needed:
                break
        else:
            raise AssertionError("its events do not end")
        self.next = next_time if next_defined else np.inf
        self.fmu.enterContinuousTimeMode()
        if self.x.size:
            self.fmu.getContinuousStates(self.pointer(self.x), self.x.size)
        self.z = self.indicators()

    def indicators(self):
        z = np.zeros(self.described.numberOfEventIndicators)
        if z.size:
            self.fmu.getEventIndicators(self.pointer(z), z.size)
        return z

    def place(self, time, x):
        self.fmu.setTime(time)
        if x.size:
            self.fmu.setContinuousStates(self.pointer(x), x.size)

    def rate(self, time, x):
        self.place(time, x)
        rate = np.zeros(x.size)
        if x.size:
            self.fmu.getDerivatives(self.pointer(rate), rate.size)
        return rate

    def attempt(self, time, step):
        """The states after a step, and whether an indicator is in another domain there."""
        x = self.x
        a = self.rate(time, x)
        b = self.rate(time + step / 2, x + step / 2 * a)
        c = self.rate(time + step / 2, x + step / 2 * b)
        d = self.rate(time + step, x + step * c)
        x = x + step / 6 * (a + 2 * b + 2 * c + d)
        self.place(time + step, x)
        return x, ((self.indicators() > 0) != (self.z > 0)).any()

    def event(self):
        self.fmu.enterEventMode()
        self.update()

    def step(self, time, step):
        end = time + step
        for _ in range(1000):
            if time >= self.next - SAME:
                self.event()
            if end - time <= SAME:
                return
            limit = min(end, self.next)
            step = limit - time
            x, crossed = self.attempt(time, step)
            before = 0.0
            if not crossed and self.attempt(time, step / 2)[1]:
                step, crossed = step / 2, True
            while crossed and step - before > LOCATED:
                middle = (before + step) / 2
                before, step = (before, middle) if self.attempt(time, middle)[1] else (middle, step)
            self.x, _ = self.attempt(time, step)
            time = time + step if crossed else limit
            asked, terminate = self.fmu.completedIntegratorStep()
            assert not terminate, "it ends the run"
            if crossed or asked:
                self.event()
            else:
                self.z = self.indicators()
        raise AssertionError("it has too many events")


if __name__ == "__main__":
    interface, fmu, step, *names = sys.argv[1:]
    times = json.load(sys.stdin)
    running = {"cs": Stepped, "me": Integrated}[interface](fmu, times[0], times[-1])
    rows = [running.row(names)]
    for time in times[:-1]:
        running.step(time, float(step))
        rows.append(running.row(names))
    print(json.dumps(rows))
