"""Characterisation data of the files that are measured, which can all be evaluated."""

from __future__ import annotations

from gamutcore.characterisation import GamutMesh, IccProfile, Picture, Samples, characterisation

__all__ = ["device_data"]


def device_data(data: bytes) -> Samples | IccProfile | Picture:
    """Return the characterisation data in the bytes of a file, which is not a mesh.

    Raises
    ------
    TypeError
        It is a mesh: that has a surface already, and none is sampled.
    """
    device = characterisation(data)
    if isinstance(device, GamutMesh):
        raise TypeError("the file is a mesh, and what is measured samples the surface of a device")
    return device
