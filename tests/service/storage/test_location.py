"""The trials pass on stores that keep their promises, and find each broken promise by itself."""

import io
import sys

import pytest

from service.__main__ import main
from service.storage import StoreLocationError, blobs_at, gamut_store, is_address, maintenance
from service.storage.cloud import CloudBlobs
from service.storage.local import LocalBlobs
from service.storage.maintenance import NOT_PROVED, findings, report


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


def refuted(blobs, another=None):
    found = findings(blobs, another or blobs)
    return [f"{each.promise} ({each.detail})" for each in found if not each.proved]


@pytest.mark.slow
def test_every_storage_passes_and_is_left_as_it_was(blobs):
    blobs.create("jobs/ab/other.job", b"x")
    assert refuted(blobs) == []
    assert list(blobs.keys("")) == ["jobs/ab/other.job"]


class Broken:
    """A local storage with one method replaced."""

    def __init__(self, blobs, **methods):
        self._blobs = blobs
        self._methods = methods

    def __getattr__(self, name):
        if name in self._methods:
            return lambda *arguments: self._methods[name](self._blobs, *arguments)
        return getattr(self._blobs, name)


def overwriting(blobs, key, content):
    """An object store that ignores the condition of a put."""
    while (version := blobs.create(key, content)) is None:
        blobs.delete(key)
    return version


def unconditional(blobs, key, data, _version):
    while (version := blobs.replace(key, data, blobs.read(key).version)) is None:
        pass
    return version


def late(blobs, prefix, after=""):
    """An eventually consistent listing."""
    return iter(list(blobs.keys(prefix, after))[:-1])


def lossy(blobs, key):
    blob = blobs.read(key)
    return blob._replace(data=blob.data[:-1])


@pytest.mark.parametrize(
    ("name", "method", "promise"),
    [
        ("create", overwriting, "simultaneous creators"),
        ("replace", unconditional, "simultaneous replacements"),
        ("replace", unconditional, "outdated"),
        ("keys", late, "listed"),
        ("read", lossy, "complete"),
        ("delete", lambda _blobs, _key: True, "deleted"),
        ("move", lambda _blobs, _key, _to: False, "moved"),
        ("size", lambda _blobs, _key: 0, "large"),
    ],
)
@pytest.mark.slow
def test_a_broken_promise_is_found(local, monkeypatch, name, method, promise):
    monkeypatch.setattr(maintenance, "_ROUNDS", 2)
    monkeypatch.setattr(maintenance, "_WRITERS", 6)
    monkeypatch.setattr(maintenance, "_LARGE", 100_000)
    assert any(promise in found for found in refuted(Broken(local, **{name: method})))


def test_what_does_not_answer_is_no_proof(local):
    def fail(*_):
        raise OSError(5, "a bad disk")

    output = io.StringIO()
    local.close()
    broken = Broken(local, read=fail)
    assert report(broken, broken, output) == 1
    assert "a bad disk" in output.getvalue()
    assert output.getvalue().endswith("The store is not suitable.\n")
    local.open()


@pytest.mark.slow
def test_a_directory_is_checked_from_the_command_line(tmp_path, capsys):
    assert main(["store", "check", str(tmp_path)]) == 0
    output = capsys.readouterr().out
    assert "FAILED" not in output
    assert all(promise in output for promise in NOT_PROVED)


@pytest.mark.slow
def test_a_bucket_is_checked_from_the_command_line(address, capsys, monkeypatch):
    monkeypatch.setenv("GAMUT_STORE", address("s3"))
    assert main(["store", "check"]) == 0
    assert "The store is suitable." in capsys.readouterr().out


@pytest.mark.slow
def test_a_bucket_that_is_not_there_fails(address, capsys):
    address("s3")
    assert main(["store", "check", "s3://no-such-bucket"]) == 1
    assert "NoSuchBucket" in capsys.readouterr().out


def test_a_store_of_no_kind_is_refused(capsys):
    assert main(["store", "check", "ftp://somewhere"]) == 2
    assert "s3://" in capsys.readouterr().err


def test_the_missing_extra_is_named(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "service.storage.cloud", None)
    assert main(["store", "check", "s3://bucket"]) == 2
    assert "cloud" in capsys.readouterr().err
    assert main(["serve", "--store", "s3://bucket"]) == 1
    assert "cloud" in capsys.readouterr().err
