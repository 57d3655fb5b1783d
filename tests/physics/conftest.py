"""The published cases of whole triaxial tests, run once for all tests that compare with them."""

import pytest

from graincal import Packing

from .curves import Replicates, YadeCase
from .packings import SOURCES, steps_of

YADE_SCALINGS = (999, 1000, 1001)
CASES = ("truth2000", "table3_1000_p0.5", "soft_rough_1000")
PAPER_CASE, PAPER_SCALINGS = "truth2000", (998, 999, 1000, 1001, 1002)


@pytest.fixture(scope="session", params=[{}, {"accuracy": "reference"}], ids=["default", "reference"])
def options(request):
    """How exactly tests are run: by the default, and by the paper's protocol."""
    return request.param


@pytest.fixture(scope="session", params=SOURCES)
def prescribed_steps(request):
    """YADE's steps at a constant time step and a given velocity gradient."""
    return steps_of(request, ("packing_200.csv", "steps_prescribed.npz"), ("packing_1000.csv", "yade/golden_steps.npz"))


@pytest.fixture(scope="session", params=SOURCES)
def isotropic_steps(request):
    """YADE's steps with time stepper and servo."""
    return steps_of(request, ("packing_200.csv", "steps_isotropic.npz"), ("packing_2000.csv", "yade/golden_isotropic.npz"))


@pytest.fixture(scope="session")
def yade_cases(reference_data):
    """name -> the parameters of a case and YADE's replicates of it."""
    cases = {}
    for name in CASES:
        files = [reference_data / "yade" / f"{name}_{scaling}.csv" for scaling in YADE_SCALINGS]
        cases[name] = YadeCase.read(files)
    return cases


@pytest.fixture(scope="session")
def triaxial_runs(reference_data, yade_cases, options):
    """All replicates that the tests ask for, the longest first; the synthetic reference's serve two comparisons."""
    runs = Replicates()
    for name, case in yade_cases.items():
        packing = Packing.read(reference_data / case.packing)
        for scaling in PAPER_SCALINGS if name == PAPER_CASE else YADE_SCALINGS:
            runs.start((name, scaling), packing, case.theta, case.strains, case.confining_pressure, scaling, **options)
    yield runs
    runs.stop()
