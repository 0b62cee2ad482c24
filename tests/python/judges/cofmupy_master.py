"""CoFmuPy, the master of IRT Saint Exupéry, as a separate process, in the environment where it is installed.

`python cofmupy_master.py` reads a system as JSON from standard input ({"configuration": its own, "step", "stop"}) and writes
its results to standard output: {"component.variable": values}, one row per step.
"""

import contextlib
import json
import sys
import tempfile
from pathlib import Path

from cofmupy import Coordinator

if __name__ == "__main__":
    system = json.load(sys.stdin)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(sys.stderr):
        file = Path(folder, "system.json")
        file.write_text(json.dumps(system["configuration"]))
        coordinator = Coordinator()
        coordinator.start(str(file))
        coordinator.run_simulation(step_size=system["step"], end_time=system["stop"])
        results = coordinator.get_results()
    columns = {".".join(name): list(map(float, values)) for name, values in results.items() if name != "time"}
    print(json.dumps(columns))
