"""A campaign tells how it goes: to the standard logger, to a function of somebody's own, and by a live table."""

import logging

import pytest

import graincal as gc
from graincal.campaign import Calibration
from graincal.campaign.run import outlook, progress
from graincal.notation.console import PrintableConsole

from . import hyperbola

ASKED = {
    "method": "iterative-bayesian",
    "alpha": 5,
    "seed": 3,
    "workers": 1,
    "stop": gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=2),
}


def calibrate(**options):
    return gc.calibrate(hyperbola.model(), hyperbola.reference(), hyperbola.SPACE, **ASKED, **options)


@pytest.mark.parametrize("kept", [True, False])
def test_what_the_log_says_goes_to_the_standard_logger(tmp_path, caplog, kept):
    folder = tmp_path / "campaign" if kept else None
    with caplog.at_level(logging.INFO, logger="graincal"):
        result = calibrate(folder=folder)
    lines = [record.getMessage() for record in caplog.records if record.name == "graincal"]
    assert sum(line.startswith("Sample ") for line in lines) == result.evaluations
    assert lines[-1].startswith("Stops by max_iterations.")
    assert sum(record.levelno == logging.WARNING for record in caplog.records) == result.failures > 0
    if kept:
        # Behind the time.
        assert [line.split(" ", 1)[1] for line in (folder / "log.txt").read_text().splitlines()] == lines


def test_it_is_silent_by_default(capfd):
    assert any(isinstance(handler, logging.NullHandler) for handler in logging.getLogger("graincal").handlers)
    calibrate()
    assert capfd.readouterr() == ("", "")


def test_a_function_is_given_every_step():
    steps = []
    result = calibrate(progress=steps.append)
    ended, complete = [step for step in steps if not step.complete], [step for step in steps if step.complete]
    assert [step.evaluations for step in ended] == list(range(1, result.evaluations + 1))
    assert [step.number for step in complete] == [0, 1] and {step.round for step in steps} == {"iteration"}
    assert sum(step.failed for step in complete) == result.failures
    assert all(step.done == step.total for step in complete)
    assert complete[-1].smallest_error == result.best.error and ended[0].seconds_left >= 0


def test_what_the_function_raises_breaks_it_off_and_it_goes_on(tmp_path):
    def tired(step):
        if step.evaluations == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate(folder=tmp_path / "campaign", progress=tired)
    steps = []
    result = gc.resume(tmp_path / "campaign", hyperbola.model(), progress=steps.append)
    # What had ended beside the fourth is kept too.
    assert 0 < steps[-1].evaluations <= result.evaluations - 4
    assert (result.errors[~result.failed] == calibrate().errors[~result.failed]).all()


def test_true_says_how_far_it_is(capsys):
    calibrate(progress=True)
    said = capsys.readouterr().out
    assert "iteration 0" in said and "iteration 1" in said


def test_a_library_tells_too(tmp_path):
    steps = []
    gc.explore(hyperbola.model(), hyperbola.SPACE, hyperbola.STRAIN, folder=tmp_path / "library", runs=5, workers=1, progress=steps.append)
    assert [step.done for step in steps] == [1, 2, 3, 4, 5]


def test_another_progress_is_refused():
    with pytest.raises(gc.InputError, match="progress: True, False or a function"):
        calibrate(progress="yes")


@pytest.fixture
def clock(monkeypatch):
    """Seconds, which go on only where a test says so."""
    now = [0.0]
    monkeypatch.setattr(outlook.time, "monotonic", lambda: now[0])
    return now


def seen(workers=1, **options):
    asked = Calibration(hyperbola.SPACE, [gc.Experiment("drained", hyperbola.model(), hyperbola.reference())], workers=workers, **options)
    return outlook.Outlook(asked)


def test_the_time_to_the_end_is_by_the_limit_and_as_most_campaigns_go(clock):
    found = seen()
    found.expects(60, 100, None)
    found.asks(0, 20)
    assert found.words(20) == ""
    clock[0] = 100.0
    for _ in range(10):
        found.evaluated()
    # 10 s for an evaluation; 10 of this batch wait, and 40 or 80 come after it.
    assert found.words(10) == "to the end about 8 min as most campaigns go, at most about 15 min"
    found.holds(1, 20), found.holds(2, 20)
    # Beyond what most take the limit alone is left.
    assert found.words(10) == "to the end at most about 8 min"
    # And so it is where the limit comes first.
    found.expects(100, 100, None)
    assert found.words(10) == "to the end at most about 8 min"


def test_nothing_is_said_of_the_end_where_it_is_not_known(clock):
    found = seen(workers=4)
    found.asks(0, 20)
    clock[0] = 30.0
    for _ in range(4):
        found.evaluated()
    # Without a limit.
    assert found.words(16) == ""
    found = seen(workers=4)
    found.expects(None, 40, None)
    found.asks(0, 20)
    clock[0] = 60.0
    for _ in range(3):
        found.evaluated()
    # Before as many have ended as run at once.
    assert found.words(17) == ""
    found.evaluated()
    assert found.words(16) == "to the end at most about 4 min"


def test_a_limit_on_hours_ends_it_with_the_round_under_way(clock):
    found = seen()
    found.expects(None, None, 3600.0)
    found.asks(0, 20)
    clock[0] = 600.0
    for _ in range(10):
        found.evaluated()
    # 50 min are left, and a round of 20 takes 20 min.
    assert found.words(10) == "to the end at most about 70 min"


def test_runs_that_a_store_holds_are_not_to_come(clock):
    found = seen()
    found.expects(None, 40, None)
    found.holds(0, 20)
    found.asks(1, 20)
    clock[0] = 600.0
    for _ in range(10):
        found.evaluated()
    assert found.words(10) == "to the end at most about 10 min"


def test_a_campaign_says_its_limits_and_nothing_of_them_in_its_first_look(monkeypatch):
    told = []
    monkeypatch.setattr(outlook.Outlook, "expects", lambda self, *limits: told.append(limits))
    calibrate(progress=True)
    samples = calibrate().iterations[0].samples
    assert told == [(None, 2 * len(samples), None)]
    shown = progress.Progress(PrintableConsole(quiet=True))
    asked = Calibration(hyperbola.SPACE, [gc.Experiment("drained", hyperbola.model(), hyperbola.reference())])
    told.clear()
    shown.looks_first()
    shown.begins(asked)
    shown.expects(10, 20, None)
    assert told == []
    shown.begins(asked)
    shown.expects(10, 20, None)
    assert told == [(10, 20, None)]
