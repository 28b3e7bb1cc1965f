"""Put machine code into a wheel: `.ci/wheels.py` compiles it and names its folder and its tag."""

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class MachineCode(BuildHookInterface):
    """Add the folder that ``GAMUT_MACHINE_CODE`` names; ``GAMUT_WHEEL_TAG`` is the tag."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Change a wheel with machine code before it is built; the pure wheel stays as it is."""
        if folder := os.environ.get("GAMUT_MACHINE_CODE"):
            build_data["force_include"][folder] = "gamutcore/kernels/compiled"
            build_data["pure_python"] = False
            build_data["tag"] = os.environ["GAMUT_WHEEL_TAG"]
