"""The Python package: the same numbers as the program's, the same errors, and results in FMPy's form."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
import rexrov
from conftest import COSIM, NAMES, ROOT
from fmpy import simulate_fmu
from pythonfmu.builder import FmuBuilder
from rexrov import CosimError, CosimWarning, course_path, fmu_path, system_path

THRUST = {"thruster[4].force": 100.0, "thruster[5].force": 100}


def command_line(folder, *arguments):
    """Results of the program as a structured array."""
    file = folder / "results.csv"
    subprocess.run([COSIM, *map(str, arguments), "-q", "-o", file], check=True, capture_output=True)
    return np.genfromtxt(file, delimiter=",", names=True, deletechars="", replace_space=" ")


def assert_same(found, wanted):
    assert found.dtype.names == wanted.dtype.names
    for name in found.dtype.names:
        np.testing.assert_array_equal(found[name], wanted[name], err_msg=name)


def test_a_component_gives_the_numbers_of_the_command_line(tmp_path):
    arguments = [f"--start-value={name}={value}" for name, value in THRUST.items()]
    arguments += ["--stop-time", 5, "--output-variable", "velocity.*", "--step-size", 0.02]
    wanted = command_line(tmp_path, "simulate", fmu_path("RexROV"), *arguments)
    found = rexrov.simulate(
        fmu_path("RexROV"), stop_time=5, start_values=THRUST, output=["velocity.*"], step_size=0.02
    )
    assert_same(found, wanted)
    assert found["velocity.u"][-1] > 0.1


def test_results_have_the_form_of_fmpy():
    signals = np.array([(0, 0), (1, 0), (1, 100), (9, 100)], [("time", "f8"), ("thruster[4].force", "f8")])
    common = {"stop_time": 3, "output_interval": 0.5, "output": ["pose.x", "velocity.u"], "input": signals}
    found = rexrov.simulate(fmu_path("RexROV"), **common)
    wanted = simulate_fmu(str(fmu_path("RexROV")), **common)
    assert found.dtype == wanted.dtype and len(found) == len(wanted) == 7
    for name in found.dtype.names:
        np.testing.assert_allclose(found[name], wanted[name], rtol=0, atol=1e-6)
    exchanged = rexrov.simulate(fmu_path("RexROV"), **common, fmi_type="ModelExchange")
    assert 0 < np.abs(exchanged["pose.x"] - found["pose.x"]).max() < 1e-3


def test_a_system_gives_the_numbers_of_the_command_line(tmp_path):
    event = {"time": 2, "model": "dvl", "variable": "off", "action": "override", "value": True}
    scenario = {"events": [event]}
    found = rexrov.run(
        system_path("paper"),
        stop_time=8,
        output_interval=0.1,
        start_values={
            "pursuit.course": str(course_path("square")),
            "gps.seed": np.int32(7),
            "gps.sigma": np.float64(1.23456789),
            "ekf.rotate_to_ned": True,
        },
        replace={"ekf": fmu_path("EkfKinematic")},
        step={"ekf": 0.2},
        algorithm="jacobi",
        scenario=scenario,
        workers=2,
    )
    assert (found["dvl.stamp"][30:] == found["dvl.stamp"][30]).all(), "the DVL is silent"
    (tmp_path / "scenario.json").write_text(json.dumps(scenario))
    options = ["--stop-time=8", "--output-interval=0.1", "--step=ekf=0.2", "--algorithm=jacobi"]
    options += [f"--start-value=pursuit.course={course_path('square')}"]
    options += ["--start-value=gps.seed=7", "--start-value=gps.sigma=1.23456789"]
    options += [f"--replace=ekf={fmu_path('EkfKinematic')}", f"--scenario={tmp_path / 'scenario.json'}"]
    assert_same(found, command_line(tmp_path, "run", system_path("paper"), *options))


TYPES = """
import sys

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Integer, Real

class Types(Fmi2Slave):
    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.real, self.integer, self.boolean = 0.5, sys.hexversion, True
        for kind, name in ((Real, "real"), (Integer, "integer"), (Boolean, "boolean")):
            self.register_variable(kind(name, causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.boolean = not self.boolean
        return True
"""


def test_columns_have_the_types_of_the_variables(tmp_path):
    """And a component in Python runs with the Python that calls it."""
    (tmp_path / "kinds.py").write_text(TYPES)
    fmu = FmuBuilder.build_FMU(tmp_path / "kinds.py", dest=tmp_path)
    found = rexrov.simulate(fmu, stop_time=0.2, output_interval=0.1, options=["--execution-tool"])
    assert found.dtype == [("time", "f8"), ("real", "f8"), ("integer", "i4"), ("boolean", "?")]
    assert found["integer"].tolist() == [sys.hexversion] * 3 and found["boolean"].tolist() == [True, False, True]


def test_errors_are_those_of_the_command_line():
    wrong = {"thruster[4].forse": 1.0, "thruster_mode": "Warp"}
    options = [f"--start-value={name}={value}" for name, value in wrong.items()]
    done = subprocess.run([COSIM, "simulate", fmu_path("RexROV"), *options], capture_output=True, text=True)
    with pytest.raises(CosimError) as caught:
        rexrov.simulate(fmu_path("RexROV"), start_values=wrong)
    error = caught.value
    assert f"error: {error}\n" == done.stderr
    assert sorted(problem.code for problem in error.problems) == ["E202", "E204"]
    unknown = next(problem for problem in error.problems if problem.code == "E202")
    assert "thruster[4].force" in unknown.help
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.problems) == (str(error), error.problems)


def edited(folder, old, new):
    """The paper's system with a change."""
    text = system_path("paper").read_text()
    assert old in text
    text = text.replace("../fmus/", f"{fmu_path('Dvl').parent}/").replace(old, new)
    file = folder / "system.ssd"
    file.write_text(text)
    return file


def test_warnings_are_those_of_python(tmp_path):
    file = edited(tmp_path, '<ssd:System name="loop"', '<ssd:System name="loop" colour="blue"')
    with pytest.warns(CosimWarning, match="colour") as caught:
        rexrov.run(file, stop_time=0.1)
    assert caught[0].filename == __file__


def test_an_error_tells_file_and_line(tmp_path):
    file = edited(tmp_path, 'startConnector="command.u"', 'startConnector="comand.u"')
    lines = file.read_text().splitlines()
    with pytest.raises(CosimError) as caught:
        rexrov.run(file)
    assert caught.value.where == f"{file}:{1 + lines.index(next(x for x in lines if 'comand.u' in x))}"
    assert "command.u" in caught.value.help
    with pytest.raises(CosimError) as caught:
        rexrov.run(tmp_path / "nowhere.ssd")
    assert caught.value.code == "E101"


FAILING = TYPES.replace("self.boolean = not self.boolean", "assert current_time < 0.25")


def test_a_run_that_fails_on_its_way_keeps_its_results(tmp_path):
    (tmp_path / "failing.py").write_text(FAILING)
    fmu = FmuBuilder.build_FMU(tmp_path / "failing.py", dest=tmp_path)
    with pytest.raises(CosimError, match="the results until then are in `results`") as caught:
        rexrov.simulate(fmu, stop_time=1, step_size=0.1, options=["--execution-tool"])
    assert caught.value.code == "E301" and "results" in caught.value.help
    np.testing.assert_allclose(caught.value.results["time"], [0, 0.1, 0.2, 0.3])
    assert pickle.loads(pickle.dumps(caught.value)).results.dtype == caught.value.results.dtype


def test_an_option_that_does_not_exist_is_an_error():
    with pytest.raises(CosimError, match="--outptu-dir") as caught:
        rexrov.run(system_path(), options=["--outptu-dir=x"])
    assert caught.value.code == "E001"


def test_files_are_found_by_name():
    assert all(fmu_path(name).is_file() for name in NAMES)
    with pytest.raises(ValueError, match="did you mean 'EkfDynamic'"):
        fmu_path("EKFDynamic")
    with pytest.raises(ValueError, match="there are BE1, BE2, BE3, square"):
        course_path("?")


@pytest.mark.parametrize("course", ["BE1", "BE2", "BE3"])
def test_the_courses_are_those_inside_the_component(course):
    def path(course):
        return rexrov.run(system_path(), stop_time=20, start_values={"pursuit.course": course})

    assert_same(path(course), path(str(course_path(course))))


def test_a_report_shows_what_is_asked_for(tmp_path):
    table = rexrov.simulate(fmu_path("RexROV"), stop_time=2, output=["pose.*"])
    page = rexrov.report(table, tmp_path / "page.html", title="A & B", plots={"Depth": ["pose.z"]})
    text = page.read_text()
    assert "A &amp; B" in text and '"title":"Depth"' in text and '"name":"pose.z"' in text
    with pytest.raises(CosimError, match="pose.zz"):
        rexrov.report(table, tmp_path / "page.html", plots={"Depth": ["pose.zz"]})


USE = """
import numpy as np
import rexrov

table = rexrov.run(rexrov.system_path(), start_values={"pursuit.course": "BE1", "fix.seed": 1}, stop_time=1.0)
depth: np.ndarray[tuple[int, ...], np.dtype[np.void]] = table
rexrov.simulate(rexrov.fmu_path("RexROV"), fmi_type="CoSimulation", input=table)
rexrov.simulate(rexrov.fmu_path("RexROV"), fmi_type="cs")  # wrong
rexrov.run("paper.ssd", start_values=3)  # wrong
"""


def test_the_interface_is_typed(tmp_path):
    """mypy finds no fault in the package, and every wrong use of it."""
    (tmp_path / "use.py").write_text(USE)
    command = [sys.executable, "-m", "mypy", "--strict", "use.py", ROOT / "cosim" / "python" / "rexrov"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    wrong = [number for number, line in enumerate(USE.splitlines(), 1) if "# wrong" in line]
    found = [line.split(":")[:2] for line in done.stdout.splitlines() if ": error:" in line]
    assert found == [["use.py", str(number)] for number in wrong], done.stdout
