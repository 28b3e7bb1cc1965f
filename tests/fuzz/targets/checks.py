"""What a target is, and what may come of a file: finite values, or an error that says why."""

import contextlib
import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import (
    GamutMesh,
    IccProfile,
    Picture,
    Samples,
    embedded_boundary,
    embedded_measurements,
    read_characterisation,
)
from gamutcore.characterisation.meshes import GAMUT_BOUNDARY_TAGS
from gamutcore.colours import InkLimits, measured_colours, surface_colours
from gamutcore.colours.profile import profile_colours
from gamutcore.errors import GamutError

ANY_BYTES = re.compile(rb"[\s\S]{1,4}")


@contextlib.contextmanager
def refused_by_name(*others):
    """End with an error of gamutcore that says what is wrong, or with another that is accepted."""
    try:
        yield
    except GamutError as error:
        _check_told(error)
    except others:
        pass


def _check_told(error):
    assert error.message
    assert error.code != "gamut-error"


def check_file(data):
    """Raise unless the file is refused by name, or all that is read of it is finite."""
    with refused_by_name():
        check_read(read_characterisation(data))


def check_picture(data):
    """Raise as for any file; the service reports a lack of memory as build-out-of-memory."""
    with refused_by_name(MemoryError):
        check_read(read_characterisation(data))


def check_read(read):
    if isinstance(read, Samples):
        check_samples(read)
    elif isinstance(read, GamutMesh):
        assert check_mesh(read)["mesh"]
    elif isinstance(read, Picture):
        assert len(read) == len(read.counts) > 0
        assert (read.counts > 0).all()
        for popularity in (None, 0.05):
            points = surface_colours(read, popularity=popularity).points
            assert np.isfinite(points).all()
            assert len(points) > 0
    elif isinstance(read, IccProfile):
        check_profile(read)


def check_samples(samples):
    assert len(samples) > 0
    if samples.device is not None:
        assert len(samples.device) == len(samples)
        assert ((samples.device >= 0) & (samples.device <= 1)).all()
    for colours in (samples.lab, samples.xyz):
        assert colours is None or np.isfinite(colours).all()
    for intent in ("relative", "absolute"):
        with refused_by_name():
            assert np.isfinite(measured_colours(samples, intent).lab).all()


def check_mesh(mesh):
    """Raise unless a mesh is as its class says and gives a gamut; return where it came from."""
    assert np.isfinite(mesh.vertices).all()
    assert mesh.vertices.shape[1:] == mesh.faces.shape[1:] == (3,)
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)
    assert mesh.device is None or len(mesh.device) == len(mesh.vertices)
    boundary, provenance = mesh_boundary(mesh)
    assert boundary.mesh.validity(boundary.centre).is_gamut
    return provenance


def check_described_boundary(data):
    """Raise unless each intent's boundary is a gamut, or refused by name."""
    for intent in GAMUT_BOUNDARY_TAGS:
        with refused_by_name():
            check_mesh(embedded_boundary(read_characterisation(data), intent))


def check_profile(profile):
    for intent, limits in (("absolute", None), ("relative", InkLimits(250.0, 80.0))):
        with refused_by_name():
            surface = surface_colours(profile, intent=intent, surface_samples=500, limits=limits)
            assert np.isfinite(surface.points).all()
            assert np.isfinite(surface.device).all()
    # Other intents without a surface, whose sampling is the same for all intents.
    device = np.random.default_rng(0).random((300, len(profile.channels)))
    device[:2] = [[0.0], [1.0]]
    for intent in ("perceptual", "saturation"):
        with refused_by_name():
            nodes = profile.transform(intent)[0].nodes
            assert nodes is None or np.isfinite(nodes).all()
            assert np.isfinite(profile_colours(profile, device, intent).lab).all()
    measured = embedded_measurements(profile)
    assert isinstance(measured, Samples)
    assert len(measured) > 0


class Target(NamedTuple):
    """A parser: files to begin with, words of its language, and what raises for a wrong result.

    `word` is what a word is in it. `mutated` makes a file where the format has a structure that
    has to be known.
    """

    seeds: list[bytes]
    tokens: list[bytes]
    check: Callable = check_file
    word: re.Pattern = re.compile(rb"[\w.+-]+")
    mutated: Callable | None = None
