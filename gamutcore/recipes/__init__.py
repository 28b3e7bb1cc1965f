"""Recipes: device values that give a colour, by the inverse of a device model.

`InverseModel` answers for one `BlackRule`. `black_paths` has the solutions of three inks and black.
"""

from gamutcore.recipes.black_paths import GCR, LEAST_INK, SHARE, WANTED
from gamutcore.recipes.inverse import BlackRule, InverseModel, Recipes

__all__ = [
    "GCR",
    "LEAST_INK",
    "SHARE",
    "WANTED",
    "BlackRule",
    "InverseModel",
    "Recipes",
]
