"""Answers of a gamut: the methods of `gamutcore.Gamut` that ask its levels, and their results.

The kernels are in `gamutcore.queries`. This folder takes colours of any shape and space, chooses
the level, and interpolates device values.
"""
