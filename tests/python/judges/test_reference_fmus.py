"""The Reference FMUs of the Modelica Association in `cosim`, compared with their own results and FMPy's.

They are not part of this project: REFERENCE_FMUS names a checkout of modelica/Reference-FMUs in which the
FMUs were built for FMI 2.0 (cmake -B build -DFMI_VERSION=2, cmake --build build).
"""

import csv
import os
import zipfile
from pathlib import Path

import cosim
import numpy as np
import pytest
from fmpy import simulate_fmu

CHECKOUT = os.environ.get("REFERENCE_FMUS")
pytestmark = pytest.mark.skipif(not CHECKOUT, reason="REFERENCE_FMUS names no checkout")

# The step of the reference results, if the FMU does not give one.
STEPS = {"Feedthrough": 0.1, "Resource": 1.0}
MODELS = ["BouncingBall", "Dahlquist", "Feedthrough", "Resource", "Stair", "VanDerPol"]
# These end the run themselves before its stop time.
ENDS = {"Stair"}


def find(model):
    """The FMU and its reference results; columns that are numbers."""
    fmus = [
        path
        for path in Path(CHECKOUT).rglob(f"{model}.fmu")
        if b'fmiVersion="2.0"' in zipfile.ZipFile(path).read("modelDescription.xml")
    ]
    assert fmus, f"no {model}.fmu of FMI 2.0 below {CHECKOUT}"
    rows = list(csv.DictReader((Path(CHECKOUT) / model / f"{model}_out.csv").open()))
    words = {"false": 0.0, "true": 1.0}
    numbers = [name for name in rows[0] if name not in ("String_output", "Binary_output")]
    return fmus[0], {
        name: np.array([words.get(row[name]) if row[name] in words else float(row[name]) for row in rows])
        for name in numbers
    }


def simulate(model, fmu, folder, *options):
    """Results of `cosim simulate`, which does not treat an FMU that ends the run as an error."""
    output = folder / "out.csv"
    step = ["--step-size", STEPS[model]] if model in STEPS else []
    command = ["simulate", fmu, *step, "--output-file", output, *options]
    reported = cosim.run(*command).stderr
    assert (f"'{model}' ended the run at t = " in reported) == (model in ENDS)
    return cosim.read(output)


@pytest.mark.parametrize("model", MODELS)
def test_co_simulation_gives_the_reference_results(model, tmp_path):
    fmu, reference = find(model)
    results = simulate(model, fmu, tmp_path)
    rows = len(results["time"])
    compared = [name for name in reference if name in results]
    assert "time" in compared and len(compared) > 1
    # The reference has a row for an end between the steps, and duplicates rows that a tool may show once.
    assert rows >= len(reference["time"]) - 2
    for name in compared:
        wanted = reference[name][:rows]
        np.testing.assert_allclose(results[name], wanted, rtol=1e-12, atol=1e-12, err_msg=name)


@pytest.mark.parametrize("model", MODELS)
def test_model_exchange_agrees_with_cvode(model, tmp_path):
    fmu, _ = find(model)
    results = simulate(model, fmu, tmp_path, "--interface-type", "me", "--tolerance", 1e-10)
    step = results["time"][1]
    wanted = simulate_fmu(
        str(fmu), fmi_type="ModelExchange", output_interval=step, relative_tolerance=1e-10,
        record_events=False,
    )
    for name in wanted.dtype.names:
        if name in results:
            np.testing.assert_allclose(
                results[name], wanted[name][: len(results[name])], rtol=1e-6, atol=1e-6, err_msg=name
            )
