"""One FMU alone with varying inputs: the same numbers in FMPy, libcosim and `cosim simulate`."""

import cosim
import numpy as np
import pytest
from conftest import NAMES
from driven import inputs, write
from fmpy import simulate_fmu
from libcosim import single
from libcosimpy.CosimEnums import CosimVariableCausality

STEP = 0.01
STEPS = 1000


def by_fmpy(fmu, signals):
    result = simulate_fmu(
        fmu, fmi_type="CoSimulation", stop_time=STEPS * STEP, output_interval=STEP, input=signals
    )
    assert len(result) == STEPS + 1
    return {name: result[name] for name in result.dtype.names[1:]}


def by_libcosim(fmu, signals):
    """From the first step on; before it libcosim shows nothing."""
    execution = single(fmu, STEP)
    references = execution.references("fmu")
    driven = [references[name] for name in signals.dtype.names[1:]]
    outputs = execution.references("fmu", causality=CosimVariableCausality.OUTPUT)
    execution.initialize("fmu", driven, list(signals[0])[1:])
    rows = []
    for step in range(STEPS):
        execution.set("fmu", driven, list(signals[step])[1:])
        execution.step()
        rows.append(execution.observer.last_real_values(0, list(outputs.values())))
    return dict(zip(outputs, np.array(rows).T))


def by_cosim(fmu, signals, folder):
    write(signals, folder / "in.csv")
    cosim.run(
        "simulate", fmu, "--input-file", folder / "in.csv", "--step-size", STEP,
        "--stop-time", STEPS * STEP, "--output-file", folder / "out.csv",
    )
    return cosim.read(folder / "out.csv")


@pytest.mark.judge("fmpy", "trajectory equal to that of `cosim simulate`")
@pytest.mark.parametrize("name", NAMES)
def test_fmpy_and_cosim_agree(fmu, name, tmp_path):
    """To the last bits: each tool computes instants and step sizes in its own way."""
    signals = inputs(fmu(name), np.arange(STEPS + 1) * STEP)
    wanted, found = by_fmpy(fmu(name), signals), by_cosim(fmu(name), signals, tmp_path)
    assert len(wanted) > 0
    for output, values in wanted.items():
        np.testing.assert_allclose(found[output], values, rtol=1e-9, atol=1e-9, err_msg=output)


@pytest.mark.judge("libcosimpy", "trajectory equal to that of `cosim simulate`")
@pytest.mark.parametrize("name", NAMES)
def test_libcosim_and_cosim_agree(fmu, name, tmp_path):
    signals = inputs(fmu(name), np.arange(STEPS + 1) * STEP)
    wanted, found = by_libcosim(fmu(name), signals), by_cosim(fmu(name), signals, tmp_path)
    assert len(wanted) > 0
    for output, values in wanted.items():
        np.testing.assert_allclose(found[output][1:], values, rtol=1e-9, atol=1e-9, err_msg=output)
