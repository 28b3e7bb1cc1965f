"""The job book under every interleaving: two owners never both win, and what is over stays over."""

import concurrent.futures
import hashlib
import threading

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, precondition, rule

from service.jobs import book as jobs
from service.jobs.book import (
    ABANDONED_SECONDS,
    JobBook,
    JobCancelledError,
    LeaseLostError,
)
from service.problems.problem import Problem
from service.storage import blobs_at
from service.storage.blobs import Blob, BlobNotFoundError, StoreUnavailableError
from service.storage.local import LocalBlobs

JOB = "a" * 64
LEASE = 10.0
PROBLEM = Problem("build-crashed", "It died.", {"signal": 9}, "r")


class MemoryBlobs:
    """As much of `Blobs` as a job book needs, with a place for others to get in between."""

    remote = False

    def __init__(self):
        self.contents = {}
        self.lock = threading.Lock()
        self.in_between = []

    def read(self, key):
        try:
            data = self.contents[key]
        except KeyError:
            raise BlobNotFoundError(key) from None
        return Blob(data, hashlib.sha256(data).hexdigest())

    def create(self, key, content):
        self._let_others_in()
        with self.lock:
            if key in self.contents:
                return None
            self.contents[key] = content
        return hashlib.sha256(content).hexdigest()

    def replace(self, key, data, version):
        self._let_others_in()
        with self.lock:
            present = self.contents.get(key)
            if present is None or hashlib.sha256(present).hexdigest() != version:
                return None
            self.contents[key] = data
        return hashlib.sha256(data).hexdigest()

    def delete(self, key):
        return self.contents.pop(key, None) is not None

    def keys(self, prefix, after=""):
        return iter(sorted(key for key in self.contents if key.startswith(prefix) and key > after))

    def _let_others_in(self):
        if self.in_between:
            self.in_between.pop()()


class Clock:
    def __init__(self):
        self.seconds = 1_700_000_000.0

    def __call__(self):
        return self.seconds


class Book(RuleBasedStateMachine):
    """Several owners, who lose their leases, and clients, who post and cancel."""

    claims = Bundle("claims")

    def __init__(self):
        super().__init__()
        self.blobs = MemoryBlobs()
        self.clock = Clock()
        self.book = JobBook(self.blobs, clock=self.clock)
        self.tokens = []
        self.last = None
        self.accepted = self.ended = 0

    def _note_claim(self, claim):
        if claim is not None:
            assert claim.document.state == "running"
            assert all(token < claim.document.token for token in self.tokens)
            self.tokens.append(claim.document.token)
        return claim

    def _accept(self):
        document, new = self.book.accept(JOB, {"gamma": 1})
        assert not document.final
        if new and document.attempts == 0 and document.state == "queued":
            self.accepted += 1

    @rule()
    def accept(self):
        self._accept()

    @rule(target=claims, owner=st.sampled_from("abc"))
    def claim(self, owner):
        return self._note_claim(self.book.claim(JOB, owner, LEASE))

    @rule(owner=st.sampled_from("abc"))
    def claim_in_between(self, owner):
        self.blobs.in_between.append(lambda: self._note_claim(self.book.claim(JOB, owner, LEASE)))

    @rule()
    def cancel_in_between(self):
        self.blobs.in_between.append(lambda: self.book.request_cancel(JOB))

    @rule()
    def accept_in_between(self):
        self.blobs.in_between.append(self._accept)

    @rule(seconds=st.sampled_from([1.0, LEASE - 1, LEASE + 1]))
    def time_goes_by(self, seconds):
        self.clock.seconds += seconds

    @rule(target=claims, claim=claims)
    def heartbeat(self, claim):
        if claim is None:
            return None
        try:
            renewed = self.book.heartbeat(claim, "decimation", 0.5)
        except LeaseLostError:
            self._lost(claim)
            return None
        self._held(claim)
        return renewed

    @rule(claim=claims, what=st.sampled_from(["succeeded", "failed", "crashed", "release"]))
    def end(self, claim, what):
        if claim is None:
            return
        try:
            if what == "crashed":
                document = self.book.record_crash(claim, PROBLEM)
            elif what == "release":
                document = self.book.release(claim)
            else:
                problem = PROBLEM if what == "failed" else None
                document = self.book.finish(claim, what, problem)
        except LeaseLostError:
            self._lost(claim)
            return
        self._held(claim)
        self.ended += document.final
        assert document.state in {"queued", what, "failed"}

    @rule()
    def cancel(self):
        self.book.request_cancel(JOB)

    @precondition(lambda self: self.tokens)
    @rule()
    def requeue(self):
        self.book.requeue(JOB, self.tokens[-1])

    @rule(silence=st.sampled_from([0.0, LEASE]))
    def revive(self, silence):
        before = self.book.read(JOB)
        revived = self.book.revive(JOB, silence)
        if revived is not None:
            assert revived.state == "queued"
            if before.state == "running" and before.token == revived.token:
                assert before.lease_until < self.clock.seconds
                assert revived.attempts == before.attempts

    def _held(self, claim):
        """A claim that could change something was the newest of all."""
        assert claim.document.token == max(self.tokens)

    def _lost(self, claim):
        """A claim is lost only to a newer one, or when the job is not running under it."""
        document = self.book.read(JOB)
        assert document.state != "running" or document.token > claim.document.token

    @invariant()
    def the_document_is_sound(self):
        document = self.book.read(JOB)
        if document is None:
            return
        assert 0 <= document.attempts <= 3
        assert document.token == max(self.tokens, default=0)
        assert (document.finished is not None) == document.final
        assert (document.owner is None) == (document.state != "running")
        assert (document.problem is not None) == (document.state in {"failed", "cancelled"})
        if self.last is not None and self.last.final and document.created == self.last.created:
            # Nothing but a new acceptance changes what is over (or adds to it, at the same time).
            assert document == self.last or not document.final or document.state == "queued"
        self.last = document


TestInterleavings = pytest.mark.slow(Book.TestCase)
TestInterleavings.settings = settings(max_examples=150, stateful_step_count=30, deadline=None)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def blobs():
    return MemoryBlobs()


@pytest.fixture
def book(blobs, clock):
    return JobBook(blobs, clock=clock)


def test_a_job_goes_from_acceptance_to_success(book):
    document, new = book.accept(JOB, {"gamma": 1})
    assert (document.state, document.options, new) == ("queued", {"gamma": 1}, True)
    assert book.accept(JOB, {"gamma": 1}) == (document, False)
    claim = book.claim(JOB, "me", LEASE)
    assert book.claim(JOB, "me", LEASE) is None
    claim = book.heartbeat(claim, "boundary", 0.25)
    seen = book.read(JOB)
    assert (seen.state, seen.stage, seen.fraction, seen.attempts) == (
        "running",
        "boundary",
        0.25,
        1,
    )
    assert book.finish(claim, "succeeded") == book.read(JOB)
    assert book.read(JOB).state == "succeeded"
    assert book.claim(JOB, "other", LEASE) is None


def test_a_lease_that_ran_out_is_taken_over_and_the_late_owner_changes_nothing(book, clock):
    book.accept(JOB, {})
    late = book.claim(JOB, "late", LEASE)
    clock.seconds += LEASE + 1
    winner = book.claim(JOB, "winner", LEASE)
    assert winner.document.attempts == 2
    before = book.read(JOB)
    for change in (
        lambda: book.heartbeat(late, "metric", 1.0),
        lambda: book.finish(late, "failed", PROBLEM),
        lambda: book.release(late),
        lambda: book.record_crash(late, PROBLEM),
    ):
        with pytest.raises(LeaseLostError):
            change()
    assert book.read(JOB) == before


def test_a_lease_that_ran_out_and_that_nobody_took_can_be_renewed_and_an_answer_be_lost(
    book, clock
):
    book.accept(JOB, {})
    claim = book.claim(JOB, "slow", LEASE)
    clock.seconds += LEASE + 1
    book.heartbeat(claim, "metric", 0.5)  # and the new version never arrives
    assert book.claim(JOB, "other", LEASE) is None
    assert book.finish(claim, "succeeded").state == "succeeded"


def crash(book, _clock, claim):
    return book.record_crash(claim, PROBLEM)


def take_the_service_down(book, _clock, claim):
    return book.requeue(JOB, claim.document.token)


def vanish(book, clock, _claim):
    clock.seconds += LEASE + 1
    return book.read(JOB)


def be_missed(book, clock, claim):
    clock.seconds += LEASE + 1
    assert (book.revive(JOB, 1000.0) is None) == (claim.document.attempts == 3)
    return book.read(JOB)


@pytest.mark.parametrize(
    "ends",
    [
        (vanish, be_missed, crash),
        (be_missed, crash, vanish),
        (crash, take_the_service_down, be_missed),
        (crash, vanish, take_the_service_down),
    ],
)
def test_attempts_are_counted_across_owners_until_the_job_is_given_up(book, clock, ends):
    book.accept(JOB, {})
    for attempt, end in enumerate(ends, 1):
        claim = book.claim(JOB, f"owner {attempt}", LEASE)
        assert claim.document.attempts == attempt
        document = end(book, clock, claim)
        assert document.attempts == attempt
        over = "queued" if attempt < 3 else "failed"
        assert document.state == ("running" if end is vanish else over)
    assert book.claim(JOB, "another", LEASE) is None
    document = book.read(JOB)
    assert (document.state, document.attempts) == ("failed", 3)
    given = Problem.from_mapping(document.problem)
    assert given == PROBLEM if end is crash else given.code == "build-crashed"


def test_what_is_given_back_is_not_counted(book):
    book.accept(JOB, {})
    for _ in range(5):
        document = book.release(book.claim(JOB, "a", LEASE))
        assert (document.state, document.attempts, document.owner) == ("queued", 0, None)


def test_a_cancelled_job_is_over_at_once_and_its_owner_learns_of_it(book):
    book.accept(JOB, {})
    claim = book.claim(JOB, "a", LEASE)
    assert book.request_cancel(JOB).state == "cancelled"
    with pytest.raises(JobCancelledError):
        book.heartbeat(claim, "metric", 0.5)
    with pytest.raises(JobCancelledError):
        book.finish(claim, "succeeded")
    document = book.request_cancel(JOB)
    assert (document.state, document.problem["code"]) == ("cancelled", "build-cancelled")
    renewed, new = book.accept(JOB, {})
    assert (renewed.state, renewed.attempts, new) == ("queued", 0, True)
    with pytest.raises(LeaseLostError):
        book.heartbeat(claim, "metric", 0.6)


@pytest.mark.parametrize("state", ["succeeded", "failed"])
def test_what_is_over_is_begun_anew_when_it_is_asked_for_again(book, state):
    book.accept(JOB, {"gamma": 1})
    first = book.claim(JOB, "a", LEASE)
    book.finish(first, state, PROBLEM if state == "failed" else None)
    assert book.request_cancel(JOB).state == state  # only what is under way can be cancelled
    assert book.request_cancel("b" * 64) is None
    renewed, new = book.accept(JOB, {"gamma": 1})
    assert (renewed.state, renewed.attempts, renewed.problem, new) == ("queued", 0, None, True)
    assert book.claim(JOB, "b", LEASE).document.token > first.document.token


def test_a_job_that_nobody_is_heard_of_is_to_be_queued_again(book, clock):
    book.accept(JOB, {})
    clock.seconds += ABANDONED_SECONDS - 1
    assert book.accept(JOB, {})[1] is False
    clock.seconds += 2
    assert book.accept(JOB, {})[1] is True
    book.claim(JOB, "a", LEASE)
    assert book.accept(JOB, {})[1] is False
    clock.seconds += LEASE + 1
    document, new = book.accept(JOB, {})
    assert (document.state, document.attempts, new) == ("running", 1, True)


def test_only_the_claim_that_is_known_to_be_dead_is_requeued(book, blobs):
    book.accept(JOB, {})
    dead = book.claim(JOB, "dead", LEASE)
    queued = book.requeue(JOB, dead.document.token)
    assert (queued.state, queued.attempts) == ("queued", 1)
    alive = book.claim(JOB, "alive", LEASE)
    assert book.requeue(JOB, dead.document.token) == alive.document
    assert book.requeue("b" * 64, 1) is None
    blobs.in_between.append(lambda: book.request_cancel(JOB))
    assert book.requeue(JOB, alive.document.token).state == "cancelled"


def test_a_lost_job_is_queued_again_by_one_who_looks(book, blobs, clock):
    assert book.revive(JOB, 0.0) is None
    book.accept(JOB, {})
    clock.seconds += 10
    assert book.revive(JOB, 10.0) is None
    clock.seconds += 0.001
    assert book.revive(JOB, 10.0) == book.read(JOB)
    assert book.revive(JOB, 10.0) is None
    claim = book.claim(JOB, "a", LEASE)
    clock.seconds += LEASE
    assert book.revive(JOB, 0.0) is None
    clock.seconds += 0.001
    blobs.in_between.append(lambda: book.claim(JOB, "faster", LEASE))
    assert book.revive(JOB, 0.0) is None
    assert book.read(JOB).owner == "faster"
    clock.seconds += LEASE + 1
    revived = book.revive(JOB, 1000.0)
    assert (revived.state, revived.attempts, revived.owner) == ("queued", 2, None)
    with pytest.raises(LeaseLostError):
        book.finish(claim, "succeeded")
    book.request_cancel(JOB)
    clock.seconds += 10_000
    assert book.revive(JOB, 0.0) is None


def test_only_what_nobody_has_begun_is_withdrawn(book):
    assert book.withdraw(JOB, PROBLEM) is None
    book.accept(JOB, {})
    assert book.withdraw(JOB, PROBLEM).state == "failed"
    book.accept(JOB, {})
    book.claim(JOB, "a", LEASE)
    assert book.withdraw(JOB, PROBLEM).state == "running"


def test_jobs_are_paged_and_the_unfinished_found(book):
    names = [letter * 64 for letter in "bdfh"]
    for name in names:
        book.accept(name, {})
    book.finish(book.claim(names[1], "a", LEASE), "succeeded")
    assert [document.id for document in book.unfinished()] == [names[0], names[2], names[3]]
    assert [document.id for document in book.page("", 2)] == names[:2]
    assert [document.id for document in book.page(names[1], 9)] == names[2:]


def test_only_what_has_been_over_for_long_enough_is_forgotten(book, clock):
    old, young, active = (letter * 64 for letter in "abc")
    for name in (old, young, active):
        book.accept(name, {})
    book.finish(book.claim(old, "a", LEASE), "succeeded")
    clock.seconds += 100
    book.finish(book.claim(young, "a", LEASE), "failed", PROBLEM)
    assert book.forget_finished(50) == [old]
    assert [document.id for document in book.page("", 9)] == [young, active]


@pytest.fixture
def finished(book, clock):
    book.accept(JOB, {})
    book.finish(book.claim(JOB, "a", LEASE), "succeeded")
    clock.seconds += 100


@pytest.mark.usefixtures("finished")
def test_a_job_that_is_renewed_before_it_is_forgotten_stays(book, blobs):
    blobs.in_between.append(lambda: book.accept(JOB, {}))
    assert book.forget_finished(50) == []
    assert book.read(JOB).state == "queued"


@pytest.mark.usefixtures("finished")
def test_a_job_that_is_asked_for_while_it_is_forgotten_is_begun_after_that(
    book, blobs, monkeypatch
):
    delete, threads = blobs.delete, concurrent.futures.ThreadPoolExecutor()
    asked = []

    def slow_delete(key):
        asked.append(threads.submit(book.accept, JOB, {}))
        with pytest.raises(concurrent.futures.TimeoutError):
            asked[0].result(0.1)
        assert book.read(JOB) is None
        return delete(key)

    monkeypatch.setattr(blobs, "delete", slow_delete)
    monkeypatch.setattr(jobs, "_REMOVAL_WAIT", 600.0)
    with threads:
        assert book.forget_finished(50) == [JOB]
        assert asked[0].result(600)[1] is True
    assert book.read(JOB).state == "queued"


@pytest.mark.parametrize("then", ["forgotten", "asked for"])
@pytest.mark.usefixtures("finished")
def test_a_removal_whose_process_died_is_done_by_another(book, blobs, clock, monkeypatch, then):
    def dies(_key):
        raise StoreUnavailableError

    monkeypatch.setattr(jobs, "_REMOVAL_WAIT", 0.0)
    with monkeypatch.context() as patch:
        patch.setattr(blobs, "delete", dies)
        with pytest.raises(StoreUnavailableError):
            book.forget_finished(50)
    assert book.read(JOB) is book.request_cancel(JOB) is None
    assert book.page("", 9) == book.forget_finished(50) == []
    with pytest.raises(StoreUnavailableError):
        book.accept(JOB, {})
    clock.seconds += 601
    if then == "forgotten":
        assert book.forget_finished(50) == [JOB]
        assert blobs.contents == {}
    document, new = book.accept(JOB, {})
    assert (document.state, new) == ("queued", True)
    assert book.read(JOB) == document


def test_a_damaged_document_is_removed_and_the_job_begun_anew(blobs, clock):
    told = []
    book = JobBook(blobs, clock=clock, on_damaged=told.append)
    book.accept(JOB, {})
    (key,) = blobs.contents
    for damaged in (
        b"",
        blobs.contents[key][:-3],
        blobs.contents[key].replace(b"queued", b"runnin"),
    ):
        blobs.contents[key] = damaged
        assert book.read(JOB) is None
        assert book.accept(JOB, {})[1] is True
    assert told == [JOB] * 3


def test_a_damage_is_told_once_however_many_read_it(blobs, clock):
    told, others = [], threading.Barrier(5)

    def options(job_id):
        others.wait(600)  # all of them have read the damaged one by then
        return {JOB: {"gamma": 2}}[job_id]

    book = JobBook(blobs, clock=clock, lost_options=options, on_damaged=told.append)
    book.accept(JOB, {})
    (key,) = blobs.contents
    blobs.contents[key] = blobs.contents[key][:-3]
    with concurrent.futures.ThreadPoolExecutor(5) as threads:
        documents = set(map(repr, threads.map(book.read, [JOB] * 5)))
    assert len(documents) == 1
    assert told == [JOB]


def test_a_damaged_document_of_a_build_with_an_input_is_queued_anew_and_its_claim_lost(
    blobs, clock
):
    book = JobBook(blobs, clock=clock, lost_options={JOB: {"gamma": 2}}.get)
    book.accept(JOB, {"gamma": 2})
    (key,) = blobs.contents
    claim = book.claim(JOB, "a", LEASE)
    blobs.contents[key] = blobs.contents[key][:-3]
    with pytest.raises(LeaseLostError):
        book.heartbeat(claim, "metric", 0.5)
    document = book.read(JOB)
    assert (document.state, document.options) == ("queued", {"gamma": 2})
    assert document.token > claim.document.token
    assert [document.id for document in book.unfinished()] == [JOB]
    assert book.accept(JOB, {"gamma": 2})[1] is True
    assert book.claim(JOB, "b", LEASE).document.attempts == 1
    with pytest.raises(LeaseLostError):
        book.finish(claim, "succeeded")


@pytest.fixture(params=["a directory", "a bucket"])
def shared_blobs(request, tmp_path, monkeypatch):
    """Storage in which several processes compare and swap."""
    if request.param == "a directory":
        opened = LocalBlobs(tmp_path / "store")
    else:
        cloud = pytest.importorskip("service.storage.cloud")
        for name in ("_CONNECT_SECONDS", "_SILENT_SECONDS", "_REQUEST_SECONDS", "_RETRY_SECONDS"):
            monkeypatch.setattr(cloud, name, 600)
        for name, value in request.getfixturevalue("s3").items():
            monkeypatch.setenv(name, value)
        opened = blobs_at(f"s3://bucket/{tmp_path.name}")
    opened.open()
    yield opened
    opened.close()


@pytest.mark.slow
def test_of_many_who_ask_at_the_same_time_one_wins(shared_blobs, clock):
    books = [JobBook(shared_blobs, clock=clock) for _ in range(8)]

    with concurrent.futures.ThreadPoolExecutor(len(books)) as threads:
        accepted = list(threads.map(lambda book: book.accept(JOB, {}), books))
        assert sum(new for _, new in accepted) == 1
        for attempt in (1, 2):
            claims = list(threads.map(lambda book: book.claim(JOB, "x", LEASE), books))
            (claim,) = [claim for claim in claims if claim is not None]
            assert claim.document.token == claim.document.attempts == attempt
            claim = books[0].heartbeat(claim, "metric", 0.5)
            books[1].record_crash(claim, PROBLEM)
        claim = books[0].claim(JOB, "x", LEASE)
        ends = [
            lambda: books[0].finish(claim, "succeeded"),
            lambda: books[1].request_cancel(JOB),
            lambda: books[2].finish(claim, "failed", PROBLEM),
        ]
        outcomes = [threads.submit(end) for end in ends]
        won = [outcome.result() for outcome in outcomes if outcome.exception() is None]
        assert {document.state for document in won} == {books[3].read(JOB).state}
        assert [document.id for document in books[0].page("", 9)] == [JOB]
