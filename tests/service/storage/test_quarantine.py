from service.storage.blobs import StoreFullError
from service.storage.quarantine import Quarantine


def test_what_belongs_together_is_moved_with_its_reason(blobs):
    blobs.create("jobs/ab/one.job", b"1")
    blobs.create("jobs/ab/two.job", b"2")
    quarantine = Quarantine(blobs)
    assert quarantine.put(["jobs/ab/one.job", "jobs/ab/two.job"], "torn")
    one, reason, two = blobs.keys("")
    assert one.startswith("quarantine/one.job.")
    assert two.startswith("quarantine/two.job.")
    assert reason == f"{one}.reason"
    assert "torn\njobs/ab/one.job\njobs/ab/two.job\n" in blobs.read(reason).data.decode()
    assert quarantine.count == 1


def test_what_was_put_here_is_told_by_its_whole_name(blobs):
    quarantine = Quarantine(blobs)
    assert not quarantine.holds("jobs/ab/one.job")
    blobs.create("jobs/ab/one.job", b"1")
    quarantine.put(["jobs/ab/one.job"], "torn")
    assert quarantine.holds("jobs/ab/one.job")
    for other in ("jobs/ab/one.jo", "jobs/ab/on.job", "jobs/ab/one.input", "jobs/ab/two.job"):
        assert not quarantine.holds(other)


def test_what_is_gone_or_sound_by_now_is_not_moved(local):
    quarantine = Quarantine(local)
    assert not quarantine.put(["jobs/ab/one.job"], "torn")
    assert not quarantine.put(["jobs/ab/one.job"], "torn", lambda _: True)
    local.create("jobs/ab/one.job", b"sound")
    assert not quarantine.put(["jobs/ab/one.job"], "torn", lambda data: data != b"sound")
    assert quarantine.count == 0


def test_no_room_for_the_reason_is_no_reason_to_serve_it(local, monkeypatch):
    local.create("jobs/ab/one.job", b"1")

    def full(*_):
        raise StoreFullError

    monkeypatch.setattr(local, "create", full)
    assert Quarantine(local).put(["jobs/ab/one.job"], "torn")
    assert [key.partition(".")[0] for key in local.keys("")] == ["quarantine/one"]
