import subprocess
import sys

import emulators
import pytest

from service.storage.cloud import CloudBlobs
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs
from service.storage.location import StoreLocationError, blobs_at, gamut_store, is_address


@pytest.mark.parametrize(
    ("location", "kind"),
    [
        ("var/gamuts", LocalBlobs),
        ("/srv/gamuts", LocalBlobs),
        ("s3:bucket", LocalBlobs),
        ("s3://bucket", CloudBlobs),
        ("s3://bucket/some/prefix", CloudBlobs),
        ("gs://bucket/prefix", CloudBlobs),
        ("az://container/prefix", CloudBlobs),
    ],
)
def test_a_location_is_a_directory_or_a_bucket(location, kind, monkeypatch):
    monkeypatch.setenv("AZURE_STORAGE_ACCOUNT_NAME", "account")
    assert isinstance(blobs_at(location), kind)
    assert is_address(location) == (kind is CloudBlobs)


@pytest.mark.parametrize(
    "location",
    [
        "ftp://host/path",
        "s3://",
        "s3:///prefix",
        "s3://name:password@bucket",
        "s3://bucket?token=password",
        "s3://bucket#password",
    ],
)
def test_other_addresses_are_refused_and_not_repeated(location):
    with pytest.raises(StoreLocationError, match="s3://bucket/prefix") as caught:
        blobs_at(location)
    assert "password" not in str(caught.value)


def test_an_account_that_azure_needs_is_asked_for(monkeypatch):
    monkeypatch.delenv("AZURE_STORAGE_ACCOUNT_NAME", raising=False)
    with pytest.raises(StoreLocationError, match="Account must be"):
        blobs_at("az://container")


def test_the_store_is_as_the_settings_say(tmp_path):
    store = gamut_store(str(tmp_path), 12345, keep_inputs=False)
    assert store.blobs.directory == tmp_path
    assert store.blobs.limit == 12345
    assert store.keep_inputs is False


@pytest.mark.slow
def test_a_directory_needs_no_optional_package():
    code = (
        "import sys; from service.application import create_app; "
        "from service.settings import Settings; create_app(Settings()); "
        "print([name for name in sys.modules if 'obstore' in name])"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "[]"


def test_a_service_shares_its_bucket_and_bears_its_outages(
    start_server, tmp_path, built, publish_built, monkeypatch, assert_problem
):
    """What others have published it serves; while the bucket is away, what it has in memory."""
    with emulators.s3_server(tmp_path) as environment:
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        server = start_server("s3://bucket/shared")
        other = GamutStore(CloudBlobs("s3://bucket/shared"))
        other.open()
        for gamut in built:
            publish_built(other, gamut)
        address, deleted = (f"/v1/gamuts/{gamut.id}" for gamut in built)
        for part in ("", "/levels", "/history", "/mesh"):
            assert server.client.get(f"{address}{part}").status_code == 200
        assert len(server.client.get("/v1/gamuts").json()["gamuts"]) == 2
        assert server.client.delete(deleted).status_code == 204
        assert server.client.get(deleted).status_code == 404
        assert [record.id for record in other.page("", 10)] == [built[0].id]
        other.close()
        mesh = server.client.get(f"{address}/mesh").content
    answer = server.client.get(f"/v1/gamuts/{'0' * 64}")
    assert_problem(answer, 503, "store-unavailable")
    assert int(answer.headers["retry-after"]) > 0
    assert environment["AWS_ENDPOINT"] not in answer.text
    assert server.client.get(f"{address}/mesh").content == mesh
    assert server.client.get("/livez").status_code == 200
    server.kill()
