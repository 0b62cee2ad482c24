"""The paper's loop over TLS, with keys as `cosim keys` makes them: the digest of a run in one process."""

import os
import socket
import subprocess
from pathlib import Path

import pytest
from conftest import FMUS, ROOT

COSIM = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "cosim"
WORKERS = ["left", "right"]


def free_port():
    with socket.socket() as line:
        line.bind(("127.0.0.1", 0))
        return line.getsockname()[1]


def digest(done):
    """A run's report of all its recorded values."""
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stderr.splitlines() if line.startswith("digest ")]
    return lines[0].split()[1]


@pytest.fixture(scope="module")
def keys(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys") / "keys"
    names = [f"--worker={name}" for name in WORKERS]
    subprocess.run([COSIM, "keys", folder, *names], check=True, capture_output=True)
    return folder


@pytest.mark.parametrize("name", ["EkfDynamic", "EkfKinematic"])
def test_a_locked_run_has_the_digest_of_an_open_one(name, keys, tmp_path):
    run = [COSIM, "run", "examples/paper.ssd", "--replace", f"ekf={FMUS / name}.fmu", "--stop-time", "20"]
    options = {"cwd": ROOT, "capture_output": True, "text": True}
    here = subprocess.run([*run, "-o", tmp_path / "here.csv"], **options)

    endpoint = f"tls/127.0.0.1:{free_port()}"
    workers = []
    for worker in WORKERS:
        arguments = ["worker", "--name", worker, "--connect", endpoint, "--credentials", keys / worker]
        # The FMUs that a worker may load are given there.
        workers.append(subprocess.Popen([COSIM, *arguments, "--allow", FMUS], cwd=ROOT))
    try:
        arguments = ["--distributed", "--min-workers", "2", "--wait", "30", "--listen", endpoint]
        arguments += ["--credentials", keys / "orchestrator", "-o", tmp_path / "there.csv"]
        there = subprocess.run([*run, *arguments], **options)
    finally:
        for worker in workers:
            worker.terminate()
        codes = [worker.wait(10) for worker in workers]
    assert digest(there) == digest(here)
    assert (tmp_path / "there.csv").read_bytes() == (tmp_path / "here.csv").read_bytes()
    assert codes == [0, 0]
