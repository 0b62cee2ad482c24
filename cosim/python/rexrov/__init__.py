"""The RexROV underwater vehicle, its sensors, filters and guidance as FMI 2.0 components.

    import rexrov
    surge = rexrov.simulate(rexrov.fmu_path("RexROV"), stop_time=60, start_values={"thruster[4].force": 100})
    loop = rexrov.run(rexrov.system_path("paper"), start_values={"pursuit.course": "BE3"}, stop_time=330)
    print(loop["time"], loop["vehicle.pose.x"])

`python -m rexrov demo` writes a first report. The package includes the program `cosim`.
"""

from importlib.metadata import version as _version

from . import plot
from .campaigns import Campaign, campaign
from .components import ComponentError, component
from .errors import CosimError, CosimWarning, Problem
from .files import course_path, fmu_path, system_path
from .pages import report
from .program import cosim_path
from .runs import run, simulate
from .smoothing import SmoothingError, smooth
from .systems import beside
from .tables import Results

__all__ = [
    "Campaign",
    "ComponentError",
    "CosimError",
    "CosimWarning",
    "Problem",
    "Results",
    "SmoothingError",
    "beside",
    "campaign",
    "component",
    "cosim_path",
    "course_path",
    "fmu_path",
    "plot",
    "report",
    "run",
    "simulate",
    "smooth",
    "system_path",
]
__version__ = _version("rexrov")
