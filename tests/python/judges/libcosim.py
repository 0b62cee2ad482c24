"""libcosim, the master of the Open Simulation Platform, stepping one FMU or a whole system.

After every step all variables of all FMUs are read, because its last-value observer does that.
"""

from xml.sax.saxutils import quoteattr

import numpy as np
from cosim import parts
from libcosimpy.CosimEnums import CosimVariableCausality, CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

class Execution:
    """A running execution with its observer; `variables` is {slave: [description]}."""

    def __init__(self, execution):
        self.execution = execution
        self.observer = CosimObserver.create_last_value()
        self.manipulator = CosimManipulator.create_override()
        execution.add_observer(self.observer)
        execution.add_manipulator(self.manipulator)
        self.indices = {info.name.decode(): info.index for info in execution.slave_infos()}
        self.variables = {
            name: list(execution.slave_variables(index)) for name, index in self.indices.items()
        }

    def references(self, slave, *, kind=CosimVariableType.REAL, causality=None):
        """{name: value reference} of the variables of a type and causality."""
        return {
            variable.name.decode(): variable.reference
            for variable in self.variables[slave]
            if variable.type == kind.value and causality in (None, CosimVariableCausality(variable.causality))
        }

    def initialize(self, slave, references, values):
        """Start values of Real variables."""
        for reference, value in zip(references, values):
            assert self.execution.real_initial_value(self.indices[slave], reference, value)

    def set(self, slave, references, values):
        """Real inputs, for the next step."""
        assert self.manipulator.slave_real_values(self.indices[slave], references, values)

    def step(self):
        assert self.execution.step(), f"libcosim: {self.execution.status()}"

    def values(self, slave, kind=CosimVariableType.REAL):
        """{name: value} of all variables of a type, as they were read after the last step."""
        names = self.references(slave, kind=kind)
        read = {
            CosimVariableType.REAL: self.observer.last_real_values,
            CosimVariableType.INTEGER: self.observer.last_integer_values,
            CosimVariableType.BOOLEAN: self.observer.last_boolean_values,
            CosimVariableType.STRING: self.observer.last_string_values,
        }[kind]
        return dict(zip(names, read(self.indices[slave], list(names.values())))) if names else {}

    def outputs(self, steps):
        """Runs; the Real outputs after each step as columns {"slave.variable": values}."""
        columns = {
            (slave, reference): (f"{slave}.{name}", np.zeros(steps))
            for slave in self.indices
            for name, reference in self.references(
                slave, causality=CosimVariableCausality.OUTPUT
            ).items()
        }
        wanted = {}
        for slave, reference in columns:
            wanted.setdefault(slave, []).append(reference)
        for step in range(steps):
            self.step()
            for slave, references in wanted.items():
                values = self.observer.last_real_values(self.indices[slave], references)
                for reference, value in zip(references, values):
                    columns[slave, reference][1][step] = value
        return dict(columns.values())


def silence():
    """Only messages that need attention."""
    log_output_level(CosimLogLevel.WARNING)


def single(fmu, step):
    """One FMU."""
    silence()
    execution = CosimExecution.from_step_size(round(step * 1e9))
    slave = CosimLocalSlave(fmu, "fmu")
    assert execution.add_local_slave(slave) >= 0
    running = Execution(execution)
    running.slave = slave  # It must outlive the execution.
    return running


def system(ssd, folder, base_step):
    """The system of an SSP description, given to libcosim as an OspSystemStructure.xml in `folder`."""
    silence()
    (folder / "OspSystemStructure.xml").write_text(osp(ssd, base_step))
    return Execution(CosimExecution.from_osp_config_file(str(folder)))


def osp(ssd, base_step):
    """OspSystemStructure.xml for an SSP description with components, parameters and connections."""
    components, ends = parts(ssd)
    simulators = []
    for name, (source, values, step) in components.items():
        values = [
            f"<InitialValue variable={quoteattr(variable)}><{kind} value={quoteattr(value)}/></InitialValue>"
            for variable, (kind, value) in values.items()
        ]
        simulators.append(
            f"<Simulator name={quoteattr(name)} source={quoteattr(str(source))} stepSize='{step}'>"
            f"<InitialValues>{''.join(values)}</InitialValues></Simulator>"
        )
    side = lambda end: "<Variable simulator={} name={}/>".format(*map(quoteattr, end.split(".", 1)))  # noqa: E731
    connections = [f"<VariableConnection>{side(start)}{side(end)}</VariableConnection>" for start, end in ends]
    lines = "\n".join
    return (
        "<?xml version='1.0' encoding='UTF-8'?>\n"
        "<OspSystemStructure version='0.1' xmlns='http://opensimulationplatform.com/MSMI/OSPSystemStructure'>\n"
        f"<BaseStepSize>{base_step!r}</BaseStepSize><Algorithm>fixedStep</Algorithm>\n"
        f"<Simulators>\n{lines(simulators)}\n</Simulators>\n"
        f"<Connections>\n{lines(connections)}\n</Connections>\n</OspSystemStructure>\n"
    )
