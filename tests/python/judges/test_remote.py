"""The paper's loop with its filter computed by a worker, in FMPy and libcosim: the bits of the loop here."""

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import cosim
import numpy as np
import pytest
from conftest import COSIM, FMUS, ROOT
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from libcosim import system
from logged import Log, callbacks

PAPER = ROOT / "examples" / "paper.ssd"
STOP = 20.0
COURSE = ["--start-value", "pursuit.course=BE3"]


def free_endpoint():
    with socket.socket() as line:
        line.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{line.getsockname()[1]}"


class Worker:
    """A worker that loads the packaged FMUs."""

    def __init__(self, endpoint, name="left"):
        arguments = ["worker", "--name", name, "--connect", endpoint, "--allow", FMUS]
        self.process = subprocess.Popen([COSIM, *arguments], stderr=subprocess.DEVNULL)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        assert self.process.wait(10) == 0

    def kill(self):
        """With everything that computes for it."""
        pids = [self.process.pid, *children(self.process.pid)]
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        self.process.wait(10)


def children(parent):
    return [int(pid) for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]


def proxy(name, folder, endpoint, *arguments):
    fmu = folder / f"{name}.remote.fmu"
    cosim.run("proxy", FMUS / f"{name}.fmu", "-o", fmu, "--listen", endpoint, *arguments)
    return fmu


def loop(folder, name, *arguments):
    fmu = folder / name
    cosim.run("export", PAPER, "-o", fmu, *COURSE, *arguments)
    return fmu


def assert_same(found, wanted):
    """Every bit of every column."""
    for name in wanted.dtype.names:
        np.testing.assert_array_equal(found[name], wanted[name], err_msg=name)


@pytest.mark.parametrize("name", ["EkfDynamic", "EkfKinematic"])
def test_fmpy_gets_the_bits_of_the_loop_here(name, tmp_path):
    endpoint = free_endpoint()
    remote = proxy(name, tmp_path, endpoint)
    assert validate_fmu(remote) == []
    here = loop(tmp_path, "Here.fmu", "--replace", f"ekf={FMUS / name}.fmu")
    there = loop(tmp_path, "There.fmu", "--replace", f"ekf={remote}", "--execution-tool")
    wanted = simulate_fmu(here, stop_time=STOP, output_interval=0.1)
    with Worker(endpoint):
        assert_same(simulate_fmu(there, stop_time=STOP, output_interval=0.1), wanted)


def test_libcosim_gets_the_bits_of_the_loop_here(tmp_path):
    endpoint = free_endpoint()
    remote = proxy("EkfDynamic", tmp_path, endpoint)
    text = PAPER.read_text().replace('"../target/fmus/', f'"{FMUS}/')
    (tmp_path / "here.ssd").write_text(text)
    replaced = text.replace(f'"{FMUS}/EkfDynamic.fmu"', f'"{remote}"')
    assert str(remote) in replaced
    (tmp_path / "there.ssd").write_text(replaced)
    steps = round(STOP / 0.02)
    found = {}
    with Worker(endpoint):
        for name in ["here", "there"]:
            (tmp_path / name).mkdir()
            found[name] = system(tmp_path / f"{name}.ssd", tmp_path / name, 0.02).outputs(steps)
    assert len(found["here"]) > 50
    for name, values in found["here"].items():
        np.testing.assert_array_equal(found["there"][name], values, err_msg=name)


class Driven:
    """An FMPy filter, stepped directly with varying inputs."""

    def __init__(self, fmu, folder):
        description = read_model_description(fmu)
        variables = {v.name: v.valueReference for v in description.modelVariables}
        self.inputs = [variables[f"imu.rate.{axis}"] for axis in "pqr"]
        self.outputs = [
            v.valueReference for v in description.modelVariables if v.causality == "output"
        ]
        self.instance = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="ekf",
        )
        self.log = Log()
        self.instance.instantiate(callbacks=callbacks(self.log))
        self.instance.setupExperiment(startTime=0.0)
        self.instance.enterInitializationMode()
        self.instance.exitInitializationMode()

    def run(self, first, last):
        rows = []
        for step in range(first, last):
            self.instance.setReal(self.inputs, [0.01 * step, -0.02, 1.0 / (step + 1)])
            self.instance.doStep(step * 0.02, 0.02)
            rows.append(self.instance.getReal(self.outputs))
        return rows


def test_a_killed_worker_changes_no_bit(tmp_path):
    endpoint = free_endpoint()
    remote = proxy("EkfDynamic", tmp_path, endpoint, "--save-every", "40")
    here = Driven(FMUS / "EkfDynamic.fmu", extract(FMUS / "EkfDynamic.fmu")).run(0, 300)
    with Worker(endpoint, "left") as left:
        there = Driven(remote, extract(remote))
        found = there.run(0, 150)
        with Worker(endpoint, "right"):
            left.kill()
            left.process = subprocess.Popen(["true"])
            found += there.run(150, 300)
            there.instance.terminate()
            there.instance.freeInstance()
    assert found == here
    # The warning is a format and its arguments, which only a logger in C combines.
    assert len(there.log.complaints) == 1


def test_an_importer_survives_that_nobody_comes(tmp_path):
    """In a separate process: a crash would show."""
    remote = proxy("EkfDynamic", tmp_path, free_endpoint(), "--wait", "0.5")
    script = (
        "import os, sys; from fmpy import extract, simulate_fmu\n"
        "said = []; threads = lambda: len(os.listdir('/proc/self/task')); before = threads()\n"
        "for _ in range(2):\n"
        "    try: simulate_fmu(sys.argv[1], stop_time=1.0, logger=lambda *a: said.append(a[-1]))\n"
        "    except Exception as error: print(type(error).__name__)\n"
        "print(said)\nprint(threads() - before)\n"
        "print(open(f'/proc/self/task/{os.getpid()}/children').read().split())\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(remote)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    first, second, said, threads, left = done.stdout.strip().splitlines()
    assert first == second and ("Exception" in first or "Error" in first), done.stdout
    assert "no worker" in said and "waited for" in said, said
    assert (threads, left) == ("0", "[]")
