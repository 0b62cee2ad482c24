"""Classes as components: their inputs, their possible errors, and the lifetime of their processes."""

import importlib.util
import os
import select
import subprocess
import sys
from itertools import count

import numpy as np
import pytest
import rexrov
from conftest import COSIM, ROOT
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from rexrov import ComponentError, CosimError, CosimWarning, host, system_path

NAMES = count()
PORTS = """
    rate = 10.0
    inputs = {"dvl.velocity.{u,v}": "m/s", "dvl.stamp": "s", "dvl.valid": "1", "heading": "deg"}
    outputs = {"pose.{x,y}": "m", "t": "s"}
"""


def made(folder, body, head="", ports=PORTS, name="Mine", **more):
    """The class with this body, and its FMU."""
    file = folder / f"made_{next(NAMES)}.py"
    file.write_text(f"import os\nimport numpy as np\n{head}\n\nclass {name}:\n    '''A filter.'''\n{ports}{body}\n")
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = sys.modules[file.stem] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return rexrov.component(getattr(module, name), folder / f"{file.stem}.fmu", **more)


ECHO = """
    def step(self, t, y):
        return {"t": t, "pose": [y["dvl.velocity"] @ [1, 10], y["heading"]]}
"""


def test_a_class_is_stepped_at_its_rate_with_the_inputs_of_then(tmp_path):
    fmu = made(tmp_path, ECHO, ports=PORTS.replace("10.0", "7"))
    signals = np.zeros(11, [("time", "f8"), ("dvl.velocity.u", "f8"), ("heading", "f8")])
    signals["time"] = np.arange(11) / 10
    signals["dvl.velocity.u"] = np.arange(11)
    common = {"stop_time": 1.0, "step_size": 0.1, "output_interval": 0.1, "input": signals}
    found = rexrov.simulate(fmu, **common)
    due = [round(np.floor(time * 7 + 1e-9) / 7, 9) for time in found["time"]]
    np.testing.assert_array_equal(found["t"], due)
    assert (np.diff(found["pose.x"]) >= 0).all() and found["pose.x"][-1] > 8
    elsewhere = simulate_fmu(str(fmu), stop_time=1.0, step_size=0.1, output_interval=0.1, input=signals)
    np.testing.assert_array_equal(elsewhere["t"], found["t"])


def test_the_description_is_made_from_the_declaration(tmp_path):
    body = """
    parameters = {"gain": "N.m/deg"}

    def __init__(self, gain=2.0, seed=3, on=True, name="a"):
        pass
""" + ECHO
    fmu = made(tmp_path, body)
    description = read_model_description(str(fmu), validate=True)
    found = {v.name: (v.type, v.causality, v.unit, v.start) for v in description.modelVariables}
    assert found["dvl.velocity.v"] == ("Real", "input", "m/s", "0.0")
    assert found["pose.y"] == ("Real", "output", "m", None)
    assert found["gain"] == ("Real", "parameter", "N.m/deg", "2.0")
    assert found["seed"] == ("Integer", "parameter", None, "3")
    assert found["on"] == ("Boolean", "parameter", None, "true")
    assert found["name"] == ("String", "parameter", None, "a")
    assert description.description == "A filter." and description.coSimulation.canSerializeFMUstate
    assert subprocess.run([COSIM, "validate", fmu], capture_output=True).returncode == 0
    again = fmu.read_bytes()
    assert rexrov.component(sys.modules[fmu.stem].Mine, fmu).read_bytes() == again, "the same bytes each time"


def test_parameters_reach_the_class_with_their_types(tmp_path):
    body = """
    def __init__(self, gain=2.0, times=3, on=True, name="a"):
        assert type(times) is int and type(on) is bool and name in "ab", name
        self.values = gain * times, float(on)

    def step(self, t, y):
        return np.array([[*self.values, t]]).T
"""
    fmu = made(tmp_path, body)
    found = rexrov.simulate(fmu, stop_time=0.1, start_values={"gain": 0.1, "times": 7, "on": False, "name": "b"})
    assert (found["pose.x"][0], found["pose.y"][0]) == (0.1 * 7, 0.0)


WRONG = {
    "return np.eye(3) @ np.ones(4)": ["step at t = 0.0 s: ValueError", "in step: return np.eye(3) @ np.ones(4)"],
    "return {'pose': [1, np.nan], 't': t}": ["gives nan as 'pose.y'"],
    "return {'pose': [1, 2, 3], 't': t}": ["an array of shape (3,) as 'pose', which has 2 numbers"],
    "return {'pose': [1, 2]}": ["gives no 't'"],
    "return {'poze': [1, 2], 't': t}": ["'poze'", "did you mean 'pose'?"],
    "return {'pose.x': 'one', 'pose.y': 1, 't': t}": ["gives 'one' as 'pose.x', which is a number"],
    "return None": ["gives nothing as the estimate, which has 3 numbers"],
    "return y['dvl.velocty']": ["did you mean 'dvl.velocity'?"],
    "raise SystemExit(3)": ["SystemExit: 3"],
    "os._exit(0)": ["the process of Mine ended with exit status 0"],
    "os.kill(os.getpid(), 11)": ["was killed by SIGSEGV"],
}


@pytest.mark.parametrize("line", WRONG)
def test_what_a_class_does_wrong_is_told(tmp_path, line):
    fmu = made(tmp_path, f"    def step(self, t, y):\n        {line}")
    with pytest.raises(CosimError) as caught:
        rexrov.simulate(fmu, stop_time=1)
    log = caught.value.problems[0].log[-1]
    assert all(part in log for part in WRONG[line]), log


DECLARED = {
    "rate": ("rate = 10.0", "rate = 0", "Mine.rate is 0"),
    "unit": ('"m/s"', '"knots"', "there is no unit 'knots'"),
    "missing": ("outputs =", "output =", "Mine.outputs is missing"),
    "twice": ('"t": "s"', '"heading": "deg"', "'heading' is an input and an output"),
}


@pytest.mark.parametrize("case", DECLARED)
def test_a_wrong_declaration_is_told(tmp_path, case):
    old, new, reported = DECLARED[case]
    with pytest.raises(ComponentError, match=reported):
        made(tmp_path, ECHO, ports=PORTS.replace(old, new))


def test_a_class_that_cannot_be_made_is_told(tmp_path):
    cases = {
        "def __init__(self, gain): pass": "argument 'gain' needs a default value",
        "def __init__(self, gain=None): pass": "a parameter is a number, a bool or a text",
        "def __init__(self): self.x = 1 / 0": "ZeroDivisionError: division by zero .*in __init__",
        "parameters = {'gian': 'm'}": "'gian', which is no argument",
    }
    for line, reported in cases.items():
        with pytest.raises(ComponentError, match=reported):
            made(tmp_path, f"    {line}\n{ECHO}")
    (tmp_path / "beside_it.py").write_text("scale = 2.0\n")
    sys.path.insert(0, str(tmp_path))
    head = "from beside_it import scale"
    with pytest.raises(ComponentError, match="No module named 'beside_it'.*name modules of yours by files="):
        made(tmp_path, ECHO, head=head)
    assert made(tmp_path, ECHO, head=head, files=[tmp_path / "beside_it.py"]).is_file()


def test_a_script_without_a_guard_does_not_make_itself_again(tmp_path):
    script = f"import rexrov\nclass Mine:\n{PORTS}{ECHO}\nrexrov.component(Mine)\n"
    (tmp_path / "script.py").write_text(script)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True)
    assert "if __name__ == '__main__':" in done.stderr and not (tmp_path / "Mine.fmu").exists()


def test_the_command_line_writes_the_same(tmp_path):
    fmu = made(tmp_path, ECHO)
    source = f"{fmu.with_suffix('.py')}:Mine"
    command = [sys.executable, "-m", "rexrov", "component", source, "-o", tmp_path / "other.fmu"]
    subprocess.run(command, check=True, capture_output=True)
    assert (tmp_path / "other.fmu").read_bytes() == fmu.read_bytes()
    command[4] = source.replace("Mine", "Mien")
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1 and "has no class 'Mien'; there are Mine" in done.stderr


def test_a_new_measurement_is_new_once():
    ports, seen = host.Ports(["dvl.velocity.u", "dvl.stamp", "dvl.valid"]), {}

    def new(stamp, valid):
        y = host.Measurements(ports, [1.0, stamp, valid], seen)
        return y.new("dvl"), y.new("dvl")

    both, neither = (True, True), (False, False)
    found = [new(*ping) for ping in ((0.0, 0), (0.1, 1), (0.1, 1), (0.2, np.nan), (0.2, 1), (0.1, 1))]
    assert found == [neither, both, neither, neither, both, both]
    with pytest.raises(KeyError, match="did you mean 'dvl.stamp'"):
        host.Measurements(ports, [1.0, 0.0, 0.0], seen).new("dvl2")


STATE = """
    def __init__(self, seed=1):
        self.random = np.random.default_rng(seed)
        self.sum = 0.0

    def step(self, t, y):
        self.sum += self.random.normal() + np.random.normal()
        COUNT[0] += 1
        return {"pose": [self.sum, COUNT[0]], "t": t}
"""


def test_runs_do_not_see_one_another(tmp_path):
    """Neither modules nor random numbers: the process is the same, and forks for each."""
    fmu = str(made(tmp_path, STATE.replace('"t": t', '"t": os.getppid()'), head="COUNT = [0]"))
    description, folder = read_model_description(fmu), extract(fmu)

    def instance():
        identifier = description.coSimulation.modelIdentifier
        return FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier)

    _kept = instance()  # _kept = instance()  # The library stays loaded as long as there is one.
    outputs = [v.valueReference for v in description.modelVariables if v.causality == "output"]
    found = set()
    for _ in range(30):
        one = instance()
        one.instantiate()
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        one.doStep(0.0, 0.3)
        found.add(tuple(one.getReal(outputs)))
        one.freeInstance()
    assert len(found) == 1, found
    _, count, parent = found.pop()
    assert count == 4.0 and parent != os.getpid()


def test_a_run_goes_on_from_a_snapshot(tmp_path):
    body = STATE.replace(" + np.random.normal()", "").replace("COUNT[0] += 1", "").replace("COUNT[0]", "0")
    fmu = made(tmp_path, body)
    command = [COSIM, "simulate", fmu, "--stop-time=2", "--quiet", "-o", tmp_path / "whole.csv"]
    subprocess.run(command, check=True)
    whole = (tmp_path / "whole.csv").read_bytes()
    subprocess.run([*command, "--snapshot-at=1", "--snapshot-file", tmp_path / "s.snapshot"], check=True)
    subprocess.run([*command, "--resume", tmp_path / "s.snapshot"], check=True)
    assert (tmp_path / "whole.csv").read_bytes() == whole


def test_a_state_that_cannot_be_saved_is_told(tmp_path):
    with pytest.warns(CosimWarning, match="the state of Mine cannot be saved"):
        fmu = made(tmp_path, f"    def __init__(self):\n        self.f = lambda: 0\n{ECHO}")
    assert not read_model_description(str(fmu)).coSimulation.canGetAndSetFMUstate
    assert len(rexrov.simulate(fmu, stop_time=1)) > 1


def test_a_process_ends_with_its_importer(tmp_path):
    """However it ends, and whatever the class does."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    body = f"""
    def step(self, t, y):
        with open({str(pipe)!r}, "w") as file:
            file.write(f"{{os.getpid()}} {{os.getppid()}}")
        while True:
            pass
"""
    run = subprocess.Popen([COSIM, "simulate", made(tmp_path, body), "--quiet", "-o", tmp_path / "x.csv"])
    ended = [os.pidfd_open(int(pid)) for pid in pipe.read_text().split()]
    run.kill()
    run.wait()
    for process in ended:
        assert select.select([process], [], [], 60)[0], "it goes on without its importer"
        os.close(process)


def test_isolation_holds_python_too(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("x")
    body = f"""
    def step(self, t, y):
        try:
            return [len(open({str(secret)!r}).read()), 0, t]
        except PermissionError:
            return [0, 0, t]
"""
    command = [COSIM, "simulate", made(tmp_path, body), "--stop-time=0.1", "--quiet", "-o", tmp_path / "x.csv"]
    read = [f"--allow-read={folder}" for folder in dict.fromkeys((sys.prefix, sys.base_prefix))]
    for options, opened in ([], 1), (["--isolate", "--execution-tool", *read], 0):
        subprocess.run([*command, *options], check=True)
        assert rexrov.tables.read(tmp_path / "x.csv")["pose.x"][0] == opened
    done = subprocess.run([*command, "--isolate"], capture_output=True, text=True)
    assert "an isolated run needs --execution-tool and --allow-read" in done.stderr


PAPER = """
    rate = 10.0
    inputs = {"dvl.velocity.{u,v,w}": "m/s", "fix.position.{x,y}": "m", "pressure.depth": "m"}
    inputs |= {"ahrs.attitude.yaw": "rad"}
    outputs = {"pose.{x,y,z}": "m", "pose.yaw": "rad"}
"""
FIX = """
    def __init__(self, seed=1):
        self.random = np.random.default_rng(seed)

    def step(self, t, y):
        TROUBLE
        x, y, z, yaw = *y["fix.position"], y["pressure.depth"], y["ahrs.attitude.yaw"]
        return {"pose": [x + self.random.normal() / 10, y, z, yaw]}
"""


def test_a_measurement_that_is_no_number_reaches_the_class(tmp_path):
    body = FIX.replace("TROUBLE", "").replace("z, yaw]", "-7.0 if np.isnan(z) else z, yaw]")
    fault = tmp_path / "nan.toml"
    fault.write_text('[[fault]]\nkind = "nan"\non = "pressure.depth"\nfrom = 1\nfor = 1\n')
    fmu = made(tmp_path, body, ports=PAPER)
    with pytest.warns(CosimWarning, match="is dropped, and 25 more to 'ekf'"):
        found = rexrov.run(
            system_path("paper"), replace={"ekf": fmu}, scenario=fault, stop_time=3, output_interval=0.1
        )
    lost = found["ekf.pose.z"] == -7.0
    assert lost.any() and (found["time"][lost].min(), found["time"][lost].max()) > (0.9, 1.8)
    assert not lost[found["time"] < 1].any() and not lost[found["time"] > 2.1].any()


def campaign_file(folder, replacements, more=""):
    lines = "".join(f'[replacements.{name}]\nekf = "{fmu}"\n' for name, fmu in replacements.items())
    file = folder / "campaign.toml"
    file.write_text(f"""seeds = 2\nstop-time = 3\noutput-interval = 0.5\n{more}
systems.paper = "{system_path("paper")}"
{lines}
[figures]
ate = {{ kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose" }}
[[verdict]]
figure = "ate"
at-most = 100
""")
    return file


def rows(result):
    return [{key: row[key] for key in row if key != "cpu_ms"} for row in result.rows]


def test_a_campaign_judges_a_class(tmp_path):
    fmu = made(tmp_path, FIX.replace("TROUBLE", ""), ports=PAPER)
    file = campaign_file(tmp_path, {"mine": fmu}, "replacements.ours = {}")
    one = rexrov.campaign(file, output_dir=tmp_path / "one", jobs=1)
    two = rexrov.campaign(file, output_dir=tmp_path / "two", jobs=2)
    assert rows(one) == rows(two) and len(one.rows) == 4
    assert {row["status"] for row in one.rows} == {"ok"} and one.verdict == "undecided"
    mine = [row["ate"] for row in one.rows if row["cell"] == "paper/mine"]
    assert mine[0] != mine[1], "each run has a seed of its own"
    assert "undecided" in one._repr_html_() and one.to_pandas().shape[0] == 4
    done = subprocess.run([COSIM, "replay", tmp_path / "one", "2", "-o", tmp_path / "2.csv"], capture_output=True)
    assert b"the same to the last bit" in done.stdout + done.stderr


def test_a_worker_of_a_campaign_starts_python_once(tmp_path):
    """The parent of the process of an object is the same in all runs of a worker; the process is not."""
    body = FIX.replace("TROUBLE", "").replace("y, z, yaw]", "os.getppid(), os.getpid(), yaw]")
    figures = "".join(f'{n} = {{ kind = "final", of = "ekf.pose.{n}" }}\n' for n in "yz")
    file = campaign_file(tmp_path, {"mine": made(tmp_path, body, ports=PAPER)})
    file.write_text(file.read_text().replace("seeds = 2", "seeds = 4").replace("[[verdict]]", f"{figures}[[verdict]]"))
    result = rexrov.campaign(file, output_dir=tmp_path / "results", jobs=1)
    assert {row["status"] for row in result.rows} == {"ok"}
    assert [len({row[name] for row in result.rows}) for name in "yz"] == [1, 4]


def test_what_a_class_starts_ends_with_its_run(tmp_path):
    seen = tmp_path / "seen"
    count = f"""import pathlib, subprocess
def left(seen=pathlib.Path({str(seen)!r})):
    own, known = str(os.getpid()), [line.split() for line in seen.read_text().splitlines()] if seen.exists() else []
    child = subprocess.Popen(["sleep", "60"], stdin=-3, stdout=-3, stderr=-3).pid
    seen.write_text("".join(f"{{a}} {{b}}\\n" for a, b in [*known, (own, child)]))
    return sum(pathlib.Path("/proc", b, "cmdline").exists() for a, b in known if a != own)"""
    body = FIX.replace("self.random =", "self.left = left(); self.random =").replace("TROUBLE", "")
    fmu = made(tmp_path, body.replace("y, z, yaw]", "self.left, z, yaw]"), head=count, ports=PAPER)
    seen.unlink(missing_ok=True)
    file = campaign_file(tmp_path, {"mine": fmu})
    figure = 'left = { kind = "final", of = "ekf.pose.y" }\n[[verdict]]'
    file.write_text(file.read_text().replace("seeds = 2", "seeds = 4").replace("[[verdict]]", figure))
    result = rexrov.campaign(file, output_dir=tmp_path / "results", jobs=1)
    assert [(row["status"], float(row["left"])) for row in result.rows] == [("ok", 0.0)] * 4
    assert len({line.split()[0] for line in seen.read_text().splitlines()}) == 4, "each run starts some"


def test_a_class_that_fails_costs_its_run_only(tmp_path):
    trouble = {"raises": "if t > 1: 1 / 0", "hangs": "while t > 1: pass", "dies": "if t > 1: os._exit(0)"}
    fmus = {n: made(tmp_path, FIX.replace("TROUBLE", line), ports=PAPER) for n, line in trouble.items()}
    result = rexrov.campaign(campaign_file(tmp_path, fmus, "time-limit = 2"), output_dir=tmp_path / "results")
    found = {row["cell"].split("/")[1]: (row["status"], row["reason"]) for row in result.rows}
    assert found["hangs"] == ("timed-out", "it took longer than 2 s")
    assert found["raises"][0] == "failed" and "ZeroDivisionError" in found["raises"][1]
    assert found["dies"][0] == "failed" and "ended with exit status 0" in found["dies"][1]


def test_a_class_listens_beside_a_filter(tmp_path):
    fmu = made(tmp_path, FIX.replace("TROUBLE", ""), ports=PAPER)
    system = rexrov.beside(system_path("paper"), "ekf", fmu, output_file=tmp_path / "beside.ssd")
    found, alone = (rexrov.run(s, stop_time=3, output_interval=0.1) for s in (system, system_path("paper")))
    for name in alone.dtype.names:
        np.testing.assert_array_equal(found[name], alone[name], err_msg=name)
    np.testing.assert_array_equal(found["mine.pose.z"], found["pressure.depth"])
    with pytest.raises(ValueError, match="has no component 'efk'; there are"):
        rexrov.beside(system_path("paper"), "efk", fmu)


def test_the_example_has_a_verdict_in_less_than_forty_lines(tmp_path):
    example = ROOT / "examples" / "own_ekf.py"
    assert sum(bool(line.strip()) for line in example.read_text().splitlines()) < 40
    done = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "paper/own median at most 1 pass" in done.stdout
