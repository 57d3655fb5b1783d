"""The built-in triaxial test against the synthetic reference of Hartmann, Cheng, Thornton (2022), section 4.1: their packing, their parameters.

A shear of 20 % is chaotic, and the reference is one run of it. YADE, the code that made it, comes out at 1.2 to 2.0 % from it in three replicates that are
1.86 % apart on average; a single run is then 1.86 / sqrt(2) = 1.3 % from the mean of all, and the mean of five is expected at 1.3 sqrt(1 + 1/5) = 1.45 % from
the reference: 1.7 % leave a sixth. 3.5 % is nearly twice the distance of two single runs.
"""

import re

import numpy as np
import pytest

from graincal.models.contact_laws import LAWS

from .conftest import PAPER_CASE, PAPER_SCALINGS
from .curves import OBSERVABLES, sample_error

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def reference(reference_data, yade_cases):
    """The reference's curve, once its parameters are found to be those of the runs."""
    path = reference_data / "synthetic_reference.csv"
    about = path.read_text().splitlines()[0]
    case = yade_cases[PAPER_CASE]
    theta = [float(re.search(rf"\b{name} ([\d.]+)", about).group(1)) for name in LAWS["linear"].names]
    assert np.allclose(case.theta, theta, rtol=1e-9, atol=0) and case.packing.removesuffix(".csv") in about
    strain, volumetric_strain, ratio = np.loadtxt(path, delimiter=",", skiprows=2).T
    assert np.allclose(strain / 100, case.strains, rtol=0, atol=1e-6)
    return {"stress_ratio": ratio, "volumetric_strain": volumetric_strain / 100}


def test_five_replicates_agree_with_the_papers_reference(reference, triaxial_runs):
    curves = [triaxial_runs.values((PAPER_CASE, scaling)) for scaling in PAPER_SCALINGS]
    errors = [round(sample_error(reference, curve), 2) for curve in curves]
    mean = {name: np.mean([curve[name] for curve in curves], axis=0) for name in OBSERVABLES}
    assert sample_error(reference, mean) <= 1.7, errors
    assert max(errors) <= 3.5, errors
