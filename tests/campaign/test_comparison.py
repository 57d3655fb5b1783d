"""Models compared by what they predict and by their evidence."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import InputError, PythonModel, Reference, calibrate, predict
from graincal.campaign.found.comparison import compare
from graincal.inference import Stop

from .hyperbola import SPACE, STRAIN, TRUTH, model, reference, respond

OPTIONS = dict(seed=1, workers=1, method="posterior", stop=Stop(max_iterations=3))


def straight(theta):
    """A soil without a limit to its strength: the wrong model."""
    strength, dilatancy = theta
    return {"stress_ratio": 1 + 20 * strength * STRAIN, "volumetric_strain": 0.1 * STRAIN - dilatancy * STRAIN**2}


def further(theta):
    """Another test of the same soil: at a strength a quarter larger."""
    return respond(np.array([0.8, 1.0]) * theta)


@pytest.fixture(scope="module")
def results():
    return {
        "hyperbola": calibrate(model(), reference(), SPACE, **OPTIONS),
        "straight": calibrate(PythonModel(straight), reference(), SPACE, **OPTIONS),
    }


def test_the_model_that_made_the_data_has_the_larger_evidence(results):
    first, second = compare(results)
    assert first.name == "hyperbola" and first.log_evidence > second.log_evidence + 5
    assert first.score is None


def test_a_held_out_test_ranks_by_its_log_score(results):
    truth = further(TRUTH)
    held_out = Reference(STRAIN, {name: truth[name] for name in reference().names})
    scores = {
        name: predict(result, PythonModel(other), STRAIN, samples=10, workers=1).against(held_out)
        for (name, result), other in zip(results.items(), (further, straight))
    }
    first, second = compare(results, scores)
    assert first.name == "hyperbola" and first.score.log_score > second.score.log_score


def test_what_cannot_be_compared_is_refused(results):
    hyperbola = results["hyperbola"]
    with pytest.raises(InputError, match="two campaigns"):
        compare({"one": hyperbola})
    with pytest.raises(InputError, match='other: its method is "sequential-monte-carlo"'):
        compare({"one": hyperbola, "other": calibrate(model(), reference(), SPACE, seed=1, workers=1, method="sequential-monte-carlo")})
    with pytest.raises(InputError, match="other and one differ in their references"):
        compare({"one": hyperbola, "other": calibrate(model(), reference(0.9 * TRUTH), SPACE, **OPTIONS)})
    with pytest.raises(InputError, match="differ in filter.discrepancy"):
        compare({"one": hyperbola, "other": calibrate(model(), reference(), SPACE, discrepancy=True, **OPTIONS)})
    with pytest.raises(InputError, match="differ in whether the scatter of packings counts"):
        compare({"one": hyperbola, "other": calibrate(model(), reference(), SPACE, packing_scatter=False, **OPTIONS)})
