"""The published curves of Hartmann, Cheng, Thornton (2022), where they are at hand."""

import os
import tomllib
from pathlib import Path

import numpy as np
import pytest

from graincal.campaign.file.propose import propose
from graincal.data import Reference
from graincal.laboratory import understand

DATA = os.environ.get("GRAINCAL_REFERENCE_DATA")
pytestmark = pytest.mark.skipif(DATA is None, reason="GRAINCAL_REFERENCE_DATA names no folder with the published curves")


def test_the_measured_test_on_toyoura_sand() -> None:
    reference = Reference.read(Path(DATA) / "toyoura_0.5MPa.csv", strain="logarithmic")
    assert reference.control.size == 33 and not reference.notes
    assert reference.control[-1] == pytest.approx(0.1146788, abs=1e-7)
    assert np.max(reference.observables["stress_ratio"]) == 4.24
    assert reference.observables["volumetric_strain"][-1] == pytest.approx(-0.0364)


def test_the_synthetic_reference() -> None:
    reference = Reference.read(Path(DATA) / "synthetic_reference.csv", observables={"stress_ratio": 0.5, "volumetric_strain": 0.5})
    np.testing.assert_allclose(reference.control, np.arange(51) * 0.004, atol=1e-12)
    assert reference.observables["stress_ratio"][0] == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("name", ["toyoura_0.5MPa.csv", "synthetic_reference.csv"])
def test_their_proposals(name: str) -> None:
    found = understand(Path(DATA) / name)
    assert found.confining_pressure == 5e5 and not found.loops
    table = tomllib.loads(propose(found))["experiment"][0]["reference"]
    assert table["units"] == {"axial_strain": "%", "volumetric_strain": "%", "stress_ratio": "-"}
    assert table["compression"] == {"axial_strain": "positive", "volumetric_strain": "positive"}
