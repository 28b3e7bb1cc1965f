"""Encodings that pictures declare: chromaticities, colour space names, CICP and headers."""

import numpy as np
import pytest

from gamutcore.characterisation import characterisation
from gamutcore.errors import GamutError, UnsupportedPictureError

ACES_AP1 = [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767]


@pytest.mark.parametrize(
    ("extension", "attributes", "transfer", "red"),
    [
        (".exr", {"chromaticities": ACES_AP1}, "linear", (0.713, 0.293)),
        (".exr", {"oiio__ColorSpace": "lin_ap1_scene"}, "linear", (0.713, 0.293)),
        (".png", {"CICP": [9, 16, 0, 1]}, "PQ", (0.708, 0.292)),
        (".png", {"CICP": [9, 18, 0, 1]}, "HLG", (0.708, 0.292)),
        (".jxl", {"CICP": [9, 16, 0, 1]}, "PQ", (0.708, 0.292)),
        (".jxl", {"CICP": [9, 18, 0, 1]}, "HLG", (0.708, 0.292)),
    ],
)
def test_declared_encodings(written, extension, attributes, transfer, red):
    kind = "half" if extension == ".exr" else "uint16"
    found = characterisation(written(extension, kind, **attributes))
    assert found.provenance["encoding"]["from"] == "the file"
    assert found.meaning.transfer == transfer
    np.testing.assert_allclose(found.meaning.primaries[0], red, atol=1e-6)


def test_scene_linear_light_without_metadata_is_that_of_srgb(written):
    found = characterisation(written(".exr", "half"))
    assert found.provenance["encoding"]["from"] == "assumed"
    assert found.meaning.transfer == "linear"


def test_primaries_of_radiance_files(written):
    data = written(".hdr", "float")
    stated = b"_rgbe\nPRIMARIES= 0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n"
    found = characterisation(data.replace(b"_rgbe\n", stated, 1))
    assert found.meaning.primaries[0] == (0.708, 0.292)
    with pytest.raises(GamutError):
        characterisation(data.replace(b"_rgbe", b"_xyze"))


def test_logarithmic_film_densities_are_refused(written):
    data = bytearray(written(".dpx", "uint16"))
    data[801] = 1  # transfer of the first image element: printing density (SMPTE ST 268)
    with pytest.raises(UnsupportedPictureError, match="Printing density"):
        characterisation(bytes(data))
