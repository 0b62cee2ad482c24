"""Whole systems: the same trajectories in `cosim` (Jacobi) and in libcosim, step by step, to 1e-9."""

import math
import sysconfig
from pathlib import Path

import cosim
import element as element_fmu
import libcosim
import numpy as np
import pytest
from conftest import FMUS, ROOT
from pythonfmu.builder import FmuBuilder

TOLERANCE = 1e-9


def compare(ssd, folder, base_step, steps):
    """Runs a system in both masters and compares every Real output after every base step."""
    cosim.run(
        "run", ssd, "--algorithm", "jacobi", "--output-interval", base_step,
        "--stop-time", base_step * steps, "--output-file", folder / "out.csv", "--execution-tool",
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
    # It moves, using guidance and every other component.
    assert outputs["vehicle.pose.x"][-1] > 5.0
    assert len(outputs) >= 50


@pytest.fixture(scope="module")
def element(tmp_path_factory):
    return element_fmu.pack(tmp_path_factory.mktemp("element"))


def system(folder, components, connections, base_step, steps):
    """Compares a system of {name: (FMU, parameters, step)} in both masters."""
    stop_time = base_step * steps
    ssd = cosim.write_ssd(folder / "system.ssd", components, connections, stop_time)
    return compare(ssd, folder, base_step, steps)


def test_two_masses_on_springs(element, tmp_path):
    """x1'' = -4 x1 + (x2 - x1) and the like as four integrators and two gains, written in C."""
    step, part = 0.01, lambda **values: (element, values, 0.01)
    outputs = system(
        tmp_path,
        {"x": part(x0=1.0), "v": part(), "spring": part(k=-4.0)},
        [("v.x", "x.u"), ("x.x", "spring.u"), ("spring.y", "v.u")],
        step, 1000,
    )
    # The delays of Jacobi add energy, and it oscillates.
    assert np.max(outputs["x.x"]) > 1.0 > -1.0 > np.min(outputs["x.x"])


def test_an_algebraic_loop(element, tmp_path):
    """a = b / 2 + t, b = t - a / 4: Jacobi goes around it once per step."""
    outputs = system(
        tmp_path,
        {"a": (element, {"k": 0.5, "b": 1.0}, 0.1), "b": (element, {"k": -0.25, "b": 1.0}, 0.1)},
        [("b.y", "a.u"), ("a.y", "b.u")],
        0.1, 200,
    )
    assert outputs["a.y"][-1] == pytest.approx(20.0 * 1.5 / 1.125, rel=0.01)


def test_several_rates(element, tmp_path):
    """Fast, slow and slower components, in both directions and in a loop."""
    outputs = system(
        tmp_path,
        {
            "clock": (element, {"b": 1.0}, 0.01),
            "slow": (element, {"k": 2.0, "a": -1.0}, 0.05),
            "slower": (element, {"k": 3.0, "a": -0.5, "x0": 1.0}, 0.1),
            "fast": (element, {"k": -1.0, "a": -2.0}, 0.02),
        },
        [("clock.y", "slow.u"), ("slow.x", "slower.u"), ("slower.x", "fast.u"), ("fast.x", "clock.u")],
        0.01, 1000,
    )
    held = np.flatnonzero(np.diff(outputs["slower.x"])) + 1
    assert set(np.diff(held)) == {10}


def test_fifty_components(element, tmp_path):
    """A ring in which each component follows the previous one and one on the opposite side."""
    names = [f"c{number}" for number in range(50)]
    outputs = system(
        tmp_path,
        {
            name: (element, {"k": 1.0 + 0.01 * number, "a": -1.0 - 0.02 * number, "x0": math.cos(number)}, 0.01)
            for number, name in enumerate(names)
        },
        [(f"{names[n - 1]}.x", f"{name}.u") for n, name in enumerate(names)],
        0.01, 500,
    )
    assert len(outputs) == 100
    assert len({values[-1] for values in outputs.values()}) == 100


def test_with_a_component_of_pythonfmu(element, tmp_path, monkeypatch):
    """Its library expects the interpreter's symbols in the importer: FMPy has them, `cosim` loads them."""
    if sysconfig.get_config_var("Py_ENABLE_SHARED"):
        library = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("INSTSONAME")
        monkeypatch.setenv("COSIM_LIBPYTHON", str(library))
    stage = FmuBuilder.build_FMU(Path(__file__).with_name("stage.py"), tmp_path)
    outputs = system(
        tmp_path,
        {"clock": (element, {"b": 1.0}, 0.05), "stage": (stage, {}, 0.05), "after": (element, {"a": -1.0}, 0.05)},
        [("clock.y", "stage.u"), ("stage.y", "after.u")],
        0.05, 200,
    )
    assert outputs["stage.count"][-1] == 200.0
    assert outputs["stage.y"][-1] == pytest.approx(10.0 - 0.2, abs=1e-3)
