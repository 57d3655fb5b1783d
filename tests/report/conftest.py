"""Results to report, calibrated once."""

import numpy as np
import pytest

import graincal as gc

from . import soil


@pytest.fixture(scope="session")
def result():
    return soil.calibrate()


@pytest.fixture(scope="session")
def two_experiments():
    soft = gc.PythonModel(lambda theta: soil.respond(theta, stiffness=0.03))
    return gc.calibrate(
        [gc.Experiment("stiff", gc.PythonModel(soil.respond), soil.reference()), gc.Experiment("soft", soft, soil.reference(0.03))],
        space=soil.SPACE,
        method="iterative-bayesian",
        stop=soil.STOP,
        seed=3,
        workers=1,
    )


@pytest.fixture(scope="session")
def without_weights():
    """Too many evaluations fail for the weights that are asked for."""

    def respond(theta):
        if theta[0] > 10:
            raise ArithmeticError("never")
        return soil.respond([30, *theta[1:]])

    return gc.calibrate(gc.PythonModel(respond), soil.reference(), soil.SPACE, method="iterative-bayesian", stop=soil.STOP, seed=3, workers=1)


@pytest.fixture(scope="session")
def all_failed():
    return gc.calibrate(
        gc.PythonModel(lambda theta: {"stress_ratio": np.nan}), soil.reference(), soil.SPACE, method="iterative-bayesian", stop=soil.STOP, seed=3, workers=1
    )


@pytest.fixture
def running(tmp_path):
    """A campaign that a reader finds before its end."""
    from graincal.campaign.stored.store import Store
    from graincal.result import Result

    folder = tmp_path / "campaign"
    soil.calibrate(folder=folder)
    Store.open(folder).database.rows("DELETE FROM meta WHERE key LIKE 'stopped%'")
    return Result.read(folder)


@pytest.fixture(scope="session")
def strange_names():
    """Names that are no words of the field, and that HTML or TeX would take for their own."""
    x = np.arange(1.0, 11)
    model = gc.PythonModel(lambda theta: {"force <b>&$_{": theta[0] * x})
    observed = gc.Reference(x, {"force <b>&$_{": 2e8 * x}, control_name="</script>")
    space = gc.ParameterSpace({"k<n> $^$": (1e8, 5e8)}, units={"k<n> $^$": "N/m"})
    return gc.calibrate([gc.Experiment("a <i>test</i> & $more$", model, observed)], space=space, method="iterative-bayesian", stop=soil.STOP, workers=1)
