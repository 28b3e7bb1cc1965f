"""What a location means, and what is said of one that means nothing."""

import sys

import pytest

from service.__main__ import main
from service.storage import StoreLocationError, blobs_at, is_address, store_at
from service.storage.cloud import CloudBlobs
from service.storage.local import LocalBlobs


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
    store = store_at(str(tmp_path), 12345, keep_inputs=False)
    assert store.blobs.directory == tmp_path
    assert store.blobs.limit == 12345
    assert store.keep_inputs is False


def test_a_store_of_no_kind_is_refused(capsys):
    assert main(["store", "list", "ftp://somewhere"]) == 2
    assert "s3://" in capsys.readouterr().err


def test_the_missing_extra_is_named(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "service.storage.cloud", None)
    assert main(["store", "list", "s3://bucket"]) == 2
    assert "cloud" in capsys.readouterr().err
    assert main(["serve", "--store", "s3://bucket"]) == 1
    assert "cloud" in capsys.readouterr().err
