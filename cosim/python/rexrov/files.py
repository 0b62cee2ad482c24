"""The locations of the FMUs, systems and courses in this package."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

_HERE = Path(__file__).parent


def fmu_path(name: str) -> Path:
    """The FMU of a component: RexROV, Imu, Ahrs, Dvl, Gps, PressureSensor, Tachometer, Disturbance,
    NavModelAided, NavInertial, NavDynamic, NavConstantAcceleration, EkfDynamic, EkfKinematic, PurePursuit,
    VelocityController."""
    return _find("FMU", "fmus", name, ".fmu")


def system_path(name: str = "baseline") -> Path:
    """A system, as an SSP description: `baseline` has realistic sensors and all filters, `paper` is the
    closed loop of the paper."""
    return _find("system", "systems", name, ".ssd")


def course_path(name: str) -> Path:
    """A course as a file of waypoints, as a template for your own: BE1, BE2, BE3, square."""
    return _find("course", "courses", name, ".csv")


def _find(kind: str, folder: str, name: str, ending: str) -> Path:
    path = _HERE / folder / f"{name}{ending}"
    names = sorted(file.stem for file in path.parent.glob(f"*{ending}"))
    if name in names:
        return path
    likely = get_close_matches(name, names, 1, 0.5)
    hint = f"did you mean '{likely[0]}'?" if likely else f"there are {', '.join(names)}"
    raise ValueError(f"there is no {kind} '{name}'; {hint}")
