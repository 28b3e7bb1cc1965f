"""Progress of builds: to a callable, as a bar, or to nobody."""

import sys
import types

from gamutcore.building import STAGES
from gamutcore.progress import report_progress


def test_a_callable_gets_the_stages():
    told = []
    with report_progress(lambda *stage: told.append(stage)) as report:
        report("colours", 0.5)
    assert told == [("colours", 0.5)]


def test_nobody_is_told_without_tqdm(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    for progress in (True, False):
        with report_progress(progress) as report:
            report(STAGES[0], 0.0)
    assert capsys.readouterr() == ("", "")


def test_the_bar_ends_with_the_last_stage(monkeypatch):
    bars = []

    class Bar:
        def __init__(self, total, **_):
            self.total, self.n = total, 0.0
            bars.append(self)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def set_description_str(self, text, **_):
            self.text = text

        def update(self, more):
            assert more >= 0
            self.n += more

    module = types.ModuleType("tqdm.auto")
    module.tqdm = Bar
    monkeypatch.setitem(sys.modules, "tqdm.auto", module)
    with report_progress(progress=True) as report:
        for stage in STAGES:
            for fraction in (0.0, 0.5, 1.0):
                report(stage, fraction)
    assert (bars[0].n, bars[0].text) == (len(STAGES), STAGES[-1])
