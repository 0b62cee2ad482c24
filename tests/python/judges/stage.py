"""A component written in Python, exported by PythonFMU: a low-pass filter that counts its steps."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Stage(Fmi2Slave):
    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.gain = 1.0
        self.u = 0.0
        self.y = 0.0
        self.count = 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(Real("count", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y += step_size * (self.u - self.y) / 0.2
        self.count += 1.0
        return True
