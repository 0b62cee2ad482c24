"""What all tests share: the packaged FMUs, which `cargo xtask package` writes."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FMUS = ROOT / "target" / "fmus"
NAMES = [
    "RexROV",
    "Imu",
    "Dvl",
    "Gps",
    "PressureSensor",
    "EkfDynamic",
    "EkfKinematic",
    "PurePursuit",
    "VelocityController",
]


@pytest.fixture
def fmu():
    """Path of the FMU of a component."""

    def path(name):
        file = FMUS / f"{name}.fmu"
        assert file.exists(), f"{file} is missing: run `cargo xtask package`"
        return str(file)

    return path
