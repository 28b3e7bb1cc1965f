import pytest

from service.access.middleware import Access, OpenToAllError
from service.application import create_app
from service.http.cors import Cors
from service.http.middleware import BodyLimit, HeadAsGet, PlainPaths
from service.http.request_id import RequestIds
from service.meshes.fast_path import MeshFastPath
from service.settings import Settings
from service.telemetry.request_observer import RequestObserver
from service.telemetry.server_timing import ServerTiming

OURS = (
    *(RequestIds, RequestObserver, ServerTiming, Cors),
    *(HeadAsGet, Access, MeshFastPath, BodyLimit, PlainPaths),
)


def layers(app):
    """The middleware of this service around an app's router, from the outside."""
    layer = app.build_middleware_stack()
    while layer is not app.router:
        if isinstance(layer, OURS):
            yield type(layer)
        layer = layer.app


@pytest.fixture
def settings(tmp_path):
    return {"store": str(tmp_path / "store")}


def test_the_middleware_is_in_the_stated_order(settings):
    app = create_app(Settings(**settings, cors_origins="*", rate_limit=1.0))
    assert tuple(layers(app)) == OURS


def test_middleware_that_nothing_asks_for_is_left_out(settings):
    expected = [layer for layer in OURS if layer not in {Cors, Access}]
    assert list(layers(create_app(Settings(**settings)))) == expected


def test_a_service_for_everybody_has_to_be_asked_for(settings):
    with pytest.raises(OpenToAllError, match="GAMUT_ALLOW_ANONYMOUS"):
        create_app(Settings(**settings, host="0.0.0.0"))  # noqa: S104
