"""Whole systems: the same trajectories in `cosim` (Jacobi) and in libcosim, step by step, to 1e-9."""

import cosim
import libcosim
import numpy as np
import pytest
from conftest import FMUS, ROOT

TOLERANCE = 1e-9


def compare(ssd, folder, base_step, steps):
    """Runs a system in both masters and compares every Real output after every base step."""
    cosim.run(
        "run", ssd, "--algorithm", "jacobi", "--output-interval", base_step,
        "--stop-time", base_step * steps, "--output-file", folder / "out.csv",
    )
    found = cosim.read(folder / "out.csv")
    wanted = libcosim.system(ssd, folder, base_step).outputs(steps)
    assert len(wanted) > 0
    for name, values in wanted.items():
        np.testing.assert_allclose(
            found[name][1:], values, rtol=TOLERANCE, atol=TOLERANCE, err_msg=name
        )
    return wanted


def test_the_loop_of_the_paper(tmp_path):
    assert (FMUS / "RexROV.fmu").exists(), "run `cargo xtask package`"
    outputs = compare(ROOT / "examples" / "paper.ssd", tmp_path, 0.01, 3000)
    # It moves, by guidance through every component.
    assert outputs["vehicle.pose.x"][-1] > 5.0
    assert len(outputs) >= 50
