"""Whole systems as one FMU in FMPy, libcosim and the checkers: the bits of `cosim run`."""

import subprocess
import sys
import sysconfig
import threading
from pathlib import Path

import cosim
import numpy as np
import pytest
from conftest import FMUS, ROOT
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from libcosim import single
from pythonfmu.builder import FmuBuilder

PAPER = ROOT / "examples" / "paper.ssd"
STOP = 20.0
# The paper's cases: a course and a filter.
CASES = {
    f"RexROV_{course}_{name}": ["--start-value", f"pursuit.course={course}", *filters]
    for course in ("BE1", "BE2", "BE3")
    for name, filters in {
        "dynamic": [],
        "kinematic": ["--replace", f"ekf={FMUS / 'EkfKinematic.fmu'}"],
    }.items()
}


def export(folder, *arguments, system=PAPER, name="Loop.fmu"):
    cosim.run("export", system, "-o", folder / name, *arguments)
    return folder / name


def run(folder, *arguments, interval=0.1, system=PAPER):
    file = folder / "run.csv"
    options = ["--stop-time", STOP, "--output-interval", interval, "--output-file", file]
    cosim.run("run", system, *arguments, *options)
    return cosim.read(file)


def assert_same(found, wanted):
    """Every bit of every column."""
    assert len(wanted) > 50
    for name, values in wanted.items():
        if name != "time":
            np.testing.assert_array_equal(found[name], values, err_msg=name)


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    return export(tmp_path_factory.mktemp("loop"))


class Driven:
    """An FMPy instance, stepped directly."""

    def __init__(self, fmu, folder):
        description = read_model_description(fmu)
        self.instance = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="loop",
        )
        outputs = [v for v in description.modelVariables if v.causality == "output"]
        self.outputs = [v.valueReference for v in outputs if v.type == "Real"]
        self.instance.instantiate()
        self.instance.setupExperiment(startTime=0.0)
        self.instance.enterInitializationMode()
        self.instance.exitInitializationMode()

    def run(self, instants):
        for begin, end in zip(instants, instants[1:]):
            self.instance.doStep(begin, end - begin)
        return self.instance.getReal(self.outputs)

    def end(self):
        self.instance.terminate()
        self.instance.freeInstance()


@pytest.mark.parametrize("case", CASES)
def test_fmpy_gets_the_bits_of_a_run(case, tmp_path):
    fmu = export(tmp_path, *CASES[case], "--name", case)
    assert validate_fmu(fmu) == []
    found = simulate_fmu(fmu, stop_time=STOP, output_interval=0.1)
    assert_same(found, run(tmp_path, *CASES[case]))


@pytest.mark.parametrize("interval", [0.01, 0.02, 0.5])
def test_the_communication_step_changes_no_bit(loop, interval, tmp_path):
    found = simulate_fmu(loop, stop_time=STOP, output_interval=interval)
    assert_same(found, run(tmp_path, interval=interval))


def test_parameters_are_start_values(loop, tmp_path):
    values = {"gps.seed": 7, "vehicle.initial.velocity.u": 0.1}
    found = simulate_fmu(loop, stop_time=STOP, output_interval=0.1, start_values=values)
    options = [x for name, value in values.items() for x in ("--start-value", f"{name}={value}")]
    assert_same(found, run(tmp_path, *options))


def test_a_free_input_acts_as_its_start_value_does(loop, tmp_path):
    signals = np.array([(0.0, 0.3)], dtype=[("time", "f8"), ("vehicle.current.east", "f8")])
    found = simulate_fmu(loop, stop_time=STOP, output_interval=0.1, input=signals)
    wanted = run(tmp_path, "--start-value", "vehicle.current.east=0.3")
    assert_same(found, wanted)


def test_libcosim_gets_the_bits_of_a_run(loop, tmp_path):
    steps = round(STOP / 0.1)
    found = single(str(loop), 0.1).outputs(steps)
    wanted = run(tmp_path)
    del wanted["time"]
    for name, values in wanted.items():
        np.testing.assert_array_equal(found[f"fmu.{name}"], values[1:], err_msg=name)


def test_fmutool_finds_no_fault(loop):
    tool = Path(sys.executable).with_name("fmutool")
    done = subprocess.run([tool, "-input", loop, "-check"], capture_output=True, text=True)
    said = done.stdout + done.stderr
    assert "compliant with FMI-2.0" in said and "No semantic error" in said, said


def test_states_go_on_here_and_in_another_process(loop, tmp_path):
    folder = extract(loop)
    instants = list(np.arange(0, 501) * 0.01)
    first = Driven(loop, folder)
    first.run(instants[:251])
    state = first.instance.getFMUState()
    (tmp_path / "state").write_bytes(first.instance.serializeFMUState(state))
    wanted = first.run(instants[250:])
    first.instance.setFMUState(state)
    assert first.run(instants[250:]) == wanted
    first.instance.freeFMUState(state)
    first.end()
    script = (
        "import sys; sys.path[:0] = sys.argv[1:3]\n"
        "import numpy as np; from test_export import Driven, extract\n"
        "loop = sys.argv[3]; other = Driven(loop, extract(loop))\n"
        "state = other.instance.deSerializeFMUstate(open(sys.argv[4], 'rb').read())\n"
        "other.instance.setFMUState(state)\n"
        "print([x.hex() for x in other.run(list(np.arange(0, 501) * 0.01)[250:])])\n"
    )
    paths = [ROOT / "tests/python/judges", ROOT / "tests/python", loop, tmp_path / "state"]
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, paths)], capture_output=True, text=True
    )
    assert done.stdout.strip() == str([value.hex() for value in wanted]), done.stderr


def test_instances_on_threads_are_alike(loop):
    folder = extract(loop)
    instants = list(np.arange(0, 101) * 0.05)
    found = {}

    def work(place):
        instance = Driven(loop, folder)
        found[place] = instance.run(instants)
        instance.end()

    threads = [threading.Thread(target=work, args=(place,)) for place in range(20)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(found) == 20 and all(values == found[0] for values in found.values())


def test_a_component_in_python_inside(tmp_path, monkeypatch):
    """PythonFMU's library finds Python in the host, or in COSIM_LIBPYTHON."""
    library = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("INSTSONAME")
    monkeypatch.setenv("COSIM_LIBPYTHON", str(library))
    stage = FmuBuilder.build_FMU(Path(__file__).with_name("stage.py"), dest=tmp_path)
    parts = {"a": (stage, {}, 0.1), "b": (stage, {}, 0.1)}
    ssd = cosim.write_ssd(tmp_path / "stages.ssd", parts, [("a.y", "b.u")], STOP)
    fmu = export(tmp_path, "--execution-tool", system=ssd)
    assert not read_model_description(fmu).coSimulation.canGetAndSetFMUstate
    found = simulate_fmu(fmu, stop_time=STOP, output_interval=0.1, start_values={"a.u": 1.0})
    assert found["b.count"][-1] == 200 and found["b.y"][-1] == pytest.approx(1.0, abs=1e-3)


def test_the_loop_inside_another_system(loop, tmp_path):
    """Exported, put into a system, and exported again."""
    ssd = cosim.write_ssd(tmp_path / "outer.ssd", {"loop": (loop, {}, 0.1)}, [], STOP)
    outer = export(tmp_path, system=ssd, name="Outer.fmu")
    found = simulate_fmu(outer, stop_time=STOP, output_interval=0.1)
    wanted = run(tmp_path)
    for name, values in wanted.items():
        if name != "time":
            np.testing.assert_array_equal(found[f"loop.{name}"], values, err_msg=name)
