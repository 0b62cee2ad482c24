"""The log messages of an FMU in FMPy."""

from fmpy import calloc, free
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

# In each message of a filter about its health.
HEALTH = ": health: "


class Log:
    """Collects the log messages of an FMU; anything but fmi2OK is a complaint.

    Filters report their health, too: signals that no vehicle produces contradict their assumptions.
    """

    def __init__(self):
        self.complaints = []

    def __call__(self, environment, instance, status, category, message):
        text = message.decode()
        if status != 0 and HEALTH not in text:
            self.complaints.append(text)


def callbacks(log):
    """For an instance called directly. FMPy's default callbacks share a logger with its last simulation."""
    functions = fmi2CallbackFunctions()
    functions.logger = fmi2CallbackLoggerTYPE(log)
    functions.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    functions.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    return functions
