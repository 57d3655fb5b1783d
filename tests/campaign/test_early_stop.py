"""A campaign whose model can be watched: runs that cannot matter any more are stopped, kept and said, and nothing else changes."""

import json

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.found.export import export_csv
from graincal.campaign.found.status import status
from graincal.campaign.stored.log import describe_iteration
from graincal.execution import Task
from graincal.models import Model

from . import as_tasks as tasked
from .hyperbola import SPACE, STRAIN, respond
from .test_campaign import assert_same
from .test_first_look import LIMITS, TRUTH

pytestmark = pytest.mark.usefixtures("fewer_draws")

OPTIONS = {
    "method": "posterior",
    "seed": 4,
    "workers": 1,
    "batch": 12,
    "correlation_length": 0.1,
    "early_stop": True,
    "stop": gc.Stop(max_iterations=3, posterior_shift=False),
}


class Watched(Model):
    """The soil, state by state. `calls` counts the states of all runs."""

    def __init__(self, breaks_at=np.inf):
        self.states, self.breaks_at = 0, breaks_at

    def tasks(self, samples, at):
        work = tasked.Watched(lambda theta, watch: self._run(theta, at, watch))
        return [Task(work, theta) for theta in samples.theta]

    def _run(self, theta, at, watch):
        try:
            values = respond(theta)
        except ArithmeticError as error:
            return gc.Failure("error", str(error))
        for count in range(1, len(at) + 1):
            self.states += 1
            if self.states > self.breaks_at:
                raise KeyboardInterrupt
            response = gc.Response(at[:count], {name: each[:count] for name, each in values.items()}, {"seconds": 0.1 * count})
            if watch and count < len(at) and watch(response):
                return gc.Response(response.control, response.values, {**response.details, "stopped": 1})
        return response


def experiment(model, name="drained"):
    curves = respond(TRUTH)
    return gc.Experiment(name, model, gc.Reference(STRAIN, {name: curves[name] for name in LIMITS}, measurement_errors=LIMITS))


def calibrate(*models, **options):
    experiments = [experiment(model, f"test {number}") for number, model in enumerate(models)]
    return gc.calibrate(experiments, space=SPACE, **{"discrepancy": False} | OPTIONS | options)


@pytest.fixture(scope="module")
def watched(fewer_draws, tmp_path_factory):
    """A model, and the folder and result of its campaign."""
    model, folder = Watched(), tmp_path_factory.mktemp("early") / "campaign"
    return model, folder, calibrate(model, folder=folder)


def test_runs_that_cannot_matter_are_stopped_and_the_answer_is_right(watched):
    model, _, result = watched
    assert result.stopped.any() and not (result.stopped & result.failed).any()
    assert model.states < len(STRAIN) * (result.evaluations - result.failures)
    np.testing.assert_allclose(result.answer.theta, TRUTH, atol=0.02)
    assert 0 <= result.learnt[-1].dropped < 1e-3
    assert not result.stopped[result.ids == result.best.sample].any()


def test_a_stopped_run_is_kept_as_far_as_it_came(watched):
    _, folder, result = watched
    id = int(result.ids[result.stopped][0])
    response, theta = result.response(id), result.samples[result.ids == id][0]
    count = len(response.control)
    assert response.stopped and 0 < count < len(STRAIN)
    np.testing.assert_array_equal(response.values["stress_ratio"], respond(theta)["stress_ratio"][:count])
    curves = result.responses(int(result.iteration[result.ids == id][0]))
    row = list(result.iterations[int(result.iteration[result.ids == id][0])].samples.ids).index(id)
    assert np.isfinite(curves["stress_ratio"][row]).sum() == count
    assert_same(gc.Result.read(folder), result)
    np.testing.assert_array_equal(gc.Result.read(folder).stopped, result.stopped)


def test_it_is_said_wherever_runs_are_counted(watched, tmp_path):
    _, folder, result = watched
    count = int(result.stopped.sum())
    found = status(folder)
    assert (found["stopped"], found["evaluations"]) == (count, result.evaluations)
    log = (folder / "log.txt").read_text()
    assert log.count("for it cannot matter any more") == count
    last = next(iteration for iteration in result.iterations if iteration.stopped.any())
    assert f"and {last.stopped.sum()} were stopped early" in describe_iteration(last, None)
    samples = next(path for path in export_csv(result, tmp_path) if path.name == "samples.csv").read_text().splitlines()
    assert samples[0].endswith(",stopped") and sum(line.endswith(",1") for line in samples[1:]) == count
    report = result.report(tmp_path / "report.html").read_text()
    assert f"{count} run{'s were' if count > 1 else ' was'} stopped early" in report and "of the posterior's probability" in report
    json.dumps(found)


@pytest.mark.parametrize(("options", "breaks_at"), [({}, 150), ({"ahead": 1, "workers": 3}, 200)])
def test_a_campaign_that_was_broken_off_ends_as_if_it_never_was(options, breaks_at, tmp_path):
    first, second = Watched(), Watched()
    whole = calibrate(first, second, **options)
    # A sample that is stopped in one experiment is left out of the next.
    in_first = [id for id in whole.ids[whole.stopped] if whole.response(int(id), 0).stopped]
    assert in_first and all(whole.response(int(id), 1) is None for id in in_first)
    assert second.states < first.states
    assert np.isfinite(whole.errors[whole.stopped]).all()
    with pytest.raises(KeyboardInterrupt):
        calibrate(Watched(breaks_at), Watched(), folder=tmp_path / "campaign", **options)
    found = gc.resume(tmp_path / "campaign", [Watched(), Watched()])
    assert_same(found, whole)
    np.testing.assert_array_equal(found.stopped, whole.stopped)


def test_a_model_that_cannot_be_watched_runs_to_the_end():
    class Unwatched(Watched):
        def tasks(self, samples, at):
            work = tasked.Calls(lambda theta: self._run(theta, at, None))
            return [Task(work, theta) for theta in samples.theta]

    found = calibrate(Unwatched())
    assert not found.stopped.any()
    assert_same(found, calibrate(Watched(), early_stop=False))
