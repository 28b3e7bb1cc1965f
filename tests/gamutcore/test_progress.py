"""Progress of builds: to a callable, as a bar, or to nobody."""

import sys

import tqdm.auto

from gamutcore.building import STAGES, report_progress


def test_nobody_is_told_without_tqdm(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    for progress in (True, False):
        with report_progress(progress) as report:
            report(STAGES[0], 0.0)
    assert capsys.readouterr() == ("", "")


def test_the_bar_ends_with_the_last_stage(monkeypatch, capsys):
    bars = []

    class EagerBar(tqdm.auto.tqdm):
        """A bar of tqdm that is drawn at every step."""

        def __init__(self, *arguments, **more):
            super().__init__(*arguments, mininterval=0, miniters=0, **more)
            bars.append(self)

    monkeypatch.setattr("tqdm.auto.tqdm", EagerBar)
    with report_progress(progress=True) as report:
        for stage in STAGES:
            for fraction in (0.0, 0.5, 1.0):
                report(stage, fraction)
    assert bars[0].n == len(STAGES)
    drawn = [line.strip() for line in capsys.readouterr().err.split("\r") if line.strip()]
    shares = [int(line.split("%")[0].split()[-1]) for line in drawn]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0, 100)
    assert drawn[-1].startswith(STAGES[-1])
