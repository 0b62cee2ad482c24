"""An observer in Python reads from a distributed run exactly what the run writes into its results."""

import csv
import json
import os
import socket
import subprocess
import sys
from pathlib import Path

from conftest import ROOT

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def free_port():
    with socket.socket() as line:
        line.bind(("127.0.0.1", 0))
        return line.getsockname()[1]


def test_the_example_prints_what_the_run_records(tmp_path):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    results = tmp_path / "results.csv"
    arguments = ["run", "examples/paper.ssd", "--stop-time", "20", "--workers", "2", "--listen", endpoint]
    arguments += ["--telemetry", "--real-time=2", "--output-interval", "0.1", "-o", results]
    run = subprocess.Popen([TARGET / "release" / "cosim", *arguments], cwd=ROOT, stderr=subprocess.PIPE)
    example = [sys.executable, ROOT / "examples" / "observe.py", endpoint]
    while run.poll() is None:
        # Until the run listens there is nothing to connect to.
        observer = subprocess.run(example, capture_output=True, text=True, timeout=60)
        if observer.returncode == 0:
            break
    assert run.wait() == 0, run.stderr.read()
    assert observer.returncode == 0, observer.stderr

    with results.open() as file:
        recorded = {float(row.pop("time")): row for row in csv.DictReader(file)}
    lines = [line.split("\t") for line in observer.stdout.splitlines()]
    assert len(lines) >= 50
    for time, values in lines:
        row = recorded[float(time)]
        assert {name: float(text) for name, text in row.items()} == json.loads(values)
