"""Files after public bug reports: volumes of the convex hull in CIELAB, from issue 46.

`scipy.spatial.ConvexHull` takes the place of our own boundary, so that files are read and converted
here, and nothing else.
"""

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from gamutcore import Gamut
from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.pictures import open_raster
from gamutcore.colours import picture_colours
from gamutcore.errors import GamutError, MalformedProfileError, UnsupportedPictureError

REPORTS = Path(__file__).parents[3] / "data" / "reports"


def report(name):
    return (REPORTS / name).read_bytes()


def volume(name):
    """Return the volume of the convex hull of a picture's colours, and the warnings."""
    picture = read_characterisation(report(name))
    return ConvexHull(picture_colours(picture, "relative").points).volume, picture.warnings


@pytest.mark.parametrize(
    ("name", "right", "tolerance"),
    [
        ("exr-with-709-primaries-same-colours.exr", 903_572, 1e-5),
        ("exr-with-xyz-primaries.exr", 903_572, 1e-4),
        ("png-ap0-primaries-negative.png", 903_572, 1e-4),
        # The mantissas of 8 bits, cut by the writer, add 2.7 %: 927,673 from the file's bytes.
        ("hdr-with-xyz-primaries.hdr", 927_673, 1e-4),
        ("hdr-xyze.hdr", 927_673, 1e-4),
        ("exr-channels-x-y-z.exr", 903_572, 1e-4),
        ("exr-two-layers-ao-and-combined.exr", 903_572, 1e-5),
        ("exr-layer-combined-alone.exr", 903_572, 1e-5),
        ("tiff-cmyk-four-channels-reference.tif", 243_892, 1e-5),
        ("tiff-cmyk-with-alpha.tif", 243_892, 1e-5),
        ("tiff-cmyk-with-associated-alpha.tif", 243_892, 1e-5),
        ("tiff-cmyk-with-spot-channel.tif", 243_892, 1e-5),
        ("tiff-cmyk-with-spot-channel-inkset-1.tif", 243_892, 1e-5),
        ("tiff-cmyk-with-two-spot-channels.tif", 243_892, 1e-5),
    ],
)
def test_the_right_volume(name, right, tolerance):
    assert volume(name)[0] == pytest.approx(right, rel=tolerance)


def test_the_layer_that_wins_by_our_own_boundary():
    assert Gamut(report("exr-two-layers-ao-and-combined.exr")).volume == pytest.approx(
        832_255, rel=1e-5
    )


def test_channels_that_are_not_used_are_said():
    assert (
        "1 further channel of the picture is not used."
        in volume("tiff-cmyk-with-spot-channel.tif")[1]
    )
    assert volume("tiff-cmyk-with-alpha.tif")[1] == ()


def test_six_inks_are_refused_by_name():
    with pytest.raises(UnsupportedPictureError, match="6 inks and a profile of 6CLR"):
        read_characterisation(report("tiff-six-inks-with-6clr-profile.tif"))


def test_inks_are_told_by_their_names():
    picture = read_characterisation(
        report("tiff-cmyk-inkset-2-names-cyan-magenta-yellow-black.tif")
    )
    assert (picture.model, picture.warnings) == ("CMYK", ())


def test_a_profile_belongs_to_the_picture_and_not_to_its_thumbnail():
    without = volume("jpeg-no-profile-reference.jpg")
    assert volume("jpeg-no-profile-but-thumbnail-has-one.jpg") == without
    assert any("sRGB is assumed" in warning for warning in without[1])
    assert volume("jpeg-profile-twice.jpg") == volume("jpeg-p3-reference.jpg")
    for name in ("jpeg-half-a-profile-reference.jpg", "jpeg-thumbnail-then-half-a-profile.jpg"):
        with pytest.raises(MalformedProfileError, match="parts 1 of 2"):
            read_characterisation(report(name))


@pytest.mark.parametrize(
    ("name", "file_format"),
    [
        ("exr-two-layers-ao-and-combined.exr", "exr"),
        ("hdr-with-xyz-primaries.hdr", "hdr"),
        ("jpeg-profile-twice.jpg", "jpeg"),
        ("tiff-cmyk-with-two-spot-channels.tif", "tiff"),
    ],
)
@given(st.data())
def test_damaged_headers_are_read_or_refused(name, file_format, data):
    content = bytearray(report(name))
    last = len(content) if file_format == "tiff" else 1600
    for place in data.draw(st.lists(st.integers(0, last - 1), min_size=1, max_size=4)):
        content[place % len(content)] = data.draw(st.integers(0, 255))
    with suppress(GamutError), open_raster(bytes(content), file_format):
        pass
