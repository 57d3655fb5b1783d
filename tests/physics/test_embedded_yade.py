"""Whole curves against YADE wherever the tests run: packings that graincal prepared, and YADE's curves on them (tests/data/SOURCES.md).

Both engines take the same steps by the same rules, but for roundings and for YADE's 1.41044 where its time stepper means the root of two; a shear of 10 % is
chaotic, so what can agree is the mean of replicates, and no better than replicates agree among themselves. The difference of two means of n is expected
at 1 / sqrt(n) of the difference of two single runs, the floor: 1.5 floors of three leave room for a factor of 2.6. Where replicates hardly scatter, on soft rough
grains, the floor falls to a few hundredths of a percent, below what the quarter of a percent between the time steps may do: 0.3 % are allowed in any case.

With Hertz-Mindlin the two differ in the law itself: YADE keeps the shear force of a contact whose overlap falls, graincal scales it down. On this path that is
less than the floor.
"""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from graincal import Packing, demo
from graincal.models.contact_laws import LAWS

from .curves import COMPARED, Replicates, error, mean_curve, read_columns, replicate_floor, sample_error
from .packings import PREPARED

DATA = Path(__file__).parents[1] / "data"
EMBEDDED = Path(demo.__file__).with_name("packing_500.csv")
PACKINGS = dict.fromkeys(("table3", "soft_rough", "hertz"), EMBEDDED) | dict.fromkeys(("low_pressure", "high_pressure"), PREPARED / "packing_300.csv")
CASES = tuple(PACKINGS)
SCALINGS = dict.fromkeys(CASES, (999, 1000, 1001))
STRAINS = 0.004 * np.arange(26)


def curve_file(case, scaling):
    return DATA / f"yade_500_{case}_{scaling}.csv" if PACKINGS[case] == EMBEDDED else PREPARED / f"{case}_{scaling}.csv"


def about(case, scaling):
    """What the first line of a curve says of how it was made."""
    return json.loads(curve_file(case, scaling).read_text().splitlines()[0].removeprefix("#"))


@pytest.fixture(scope="module")
def replicates(options):
    runs = Replicates()
    for case, file in PACKINGS.items():
        packing = Packing.read(file)
        for scaling in SCALINGS[case]:
            facts = about(case, scaling)
            theta = [facts[name] for name in LAWS["linear"].names]
            law = facts.get("law", "linear")
            runs.start((case, scaling), packing, theta, STRAINS, facts["confining_pressure"], facts["density_scaling"], law=law, **options)
    yield runs
    runs.stop()


def test_the_curves_were_computed_on_these_packings():
    for case, packing in PACKINGS.items():
        checksum = hashlib.sha256(packing.read_bytes()).hexdigest()
        for scaling in SCALINGS[case]:
            facts = about(case, scaling)
            assert facts["packing_sha256"] == checksum
            assert facts["density_scaling"] == scaling and facts["cell_inertia"] == "graincal"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_mean_of_replicates_agrees_with_yades(replicates, case, request):
    if request.node.callspec.id == "default-high_pressure":
        request.applymarker(pytest.mark.xfail(strict=True, reason="the default is 1.12 % from YADE here, where 1.09 % are allowed: docs/verification.md"))
    yades = [read_columns(curve_file(case, scaling)) for scaling in SCALINGS[case]]
    ours = [replicates.values((case, scaling)) for scaling in SCALINGS[case]]
    for curve in yades:
        assert np.allclose(curve["axial_strain"], STRAINS, rtol=0, atol=1e-6)
    yade, our = mean_curve(yades), mean_curve(ours)
    found = {name: round(error(yade, our, name), 2) for name in COMPARED}
    assert sample_error(yade, our) <= max(1.5 * replicate_floor(yades), 0.3), found
    # A coordination number of 5 and 1,000 contacts: replicates differ by half a percent, and by 2.5 % in the anisotropy of contacts.
    assert found["coordination_number"] <= 2 and found["a_c"] <= 5, found
