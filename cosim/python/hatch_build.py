"""Sets the platform of the wheel for hatchling: its program and libraries are compiled."""

import os

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Platform(BuildHookInterface):
    def initialize(self, version, build_data):
        build_data["pure_python"] = False
        build_data["tag"] = os.environ["REXROV_TAG"]
