"""Ecos, the co-simulation engine of NTNU, as a separate process.

`python ecos_master.py` reads a system as JSON from standard input ({"step", "steps", "models": {name: FMU}, "values":
{name: number}, "connections": [[from, to]], "outputs": [name]} or {"ssp": file, ...}, with names as `model::variable`)
and writes the outputs, one list after each step, to standard output.
"""

import ctypes
import json
import sys
from pathlib import Path

# Its library needs oneTBB, which a separate package installs where the loader does not look.
ctypes.CDLL(str(Path(sys.prefix, "lib", "libtbb.so.12")), ctypes.RTLD_GLOBAL)

from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402
from ecospy.EcosParameterSet import EcosParameterSet  # noqa: E402


def run(system):
    structure = None
    if "ssp" not in system:
        structure = EcosSimulationStructure()
        for name, fmu in system["models"].items():
            structure.add_model(name, fmu)
        values = EcosParameterSet()
        for name, value in system["values"].items():
            values.add_real(name, value)
        structure.add_parameter_set("values", values)
        for start, end in system["connections"]:
            structure.make_real_connection(start, end)
    with EcosSimulation(system["step"], ssp_path=system.get("ssp"), structure=structure) as simulation:
        simulation.init(parameter_set="values" if structure else system.get("set"))
        rows = [[simulation.get_real(name) for name in system["outputs"]]]
        for _ in range(system["steps"]):
            simulation.step()
            rows.append([simulation.get_real(name) for name in system["outputs"]])
    return rows


if __name__ == "__main__":
    print(json.dumps(run(json.load(sys.stdin))))
