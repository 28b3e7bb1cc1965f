"""Whole pictures through a mapping: decoded, mapped, and written in another encoding."""

from gamutcore.pictures.mapped_file import PICTURE_PARAMETERS, map_picture_file
from gamutcore.pictures.picture_mapping import MappedPicture, TableError, no_picture
from gamutcore.pictures.picture_targets import DECODE
from gamutcore.pictures.picture_targets import DEVICE as DEVICE_VALUES

__all__ = [
    "DECODE",
    "DEVICE_VALUES",
    "PICTURE_PARAMETERS",
    "MappedPicture",
    "TableError",
    "map_picture_file",
    "no_picture",
]
