"""Put compiled kernels and built references into a wheel: `.ci/wheels.py` makes them."""

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompiledWheel(BuildHookInterface):
    """Add what ``GAMUT_WHEEL_FOLDER`` holds to the package; ``GAMUT_WHEEL_TAG`` is the tag."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Change the wheel before it is built; without the variable it is the pure one."""
        if folder := os.environ.get("GAMUT_WHEEL_FOLDER"):
            build_data["force_include"][folder] = "gamutcore"
            build_data["pure_python"] = False
            build_data["tag"] = os.environ["GAMUT_WHEEL_TAG"]
