"""A reference, as it shows itself at a prompt and in a notebook."""

from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest

import graincal as gc
from graincal.demo import packing

STRAIN = np.linspace(0, 0.12, 16)
ERRORS = {"stress_ratio": gc.MeasurementError(0.01, 0.005, noise=0.002), "volumetric_strain": gc.MeasurementError(step=1e-4)}


def drained(**options):
    return gc.Reference(
        STRAIN, {"stress_ratio": 1 + 10 * STRAIN, "volumetric_strain": -0.1 * STRAIN, "void_ratio": 0.7 + STRAIN}, measurement_errors=ERRORS, **options
    )


def test_a_reference_says_what_was_read_in_a_few_lines():
    assert repr(drained(notes=("one", "two"), control_step=1e-4)).splitlines() == [
        "Reference: 16 states over axial_strain 0 to 12 %, in steps of 0.01 %",
        "  stress_ratio       1 to 2.2, measurement error: sd 0.01, 0.5 % of each value, noise of sd 0.002",
        "  volumetric_strain  -1.2 to 0 %, measurement error: steps of 0.01 %",
        "  void_ratio         0.7 to 0.82, measurement error: none stated",
        "  2 notes on how it was read, in .notes",
    ]
    cycle = gc.Reference([0.0], {"axial_stress": [2e4]}, control_name="position", measurement_errors={"axial_stress": 150.0}, simulated=True)
    assert repr(cycle) == "Reference: 1 state over position 0 to 0, of a simulation\n  axial_stress  20 to 20 kPa, measurement error: sd 0.15 kPa"


def settings():
    """Matplotlib's, but for the backend, which is found out when it is asked for."""
    return {key: matplotlib.rcParams[key] for key in matplotlib.rcParams if key != "backend"}


def test_a_notebook_shows_a_table_the_notes_and_the_curves():
    before = settings()
    shown = drained(notes=("column 'a' < b",))._repr_html_()
    assert settings() == before
    # Well formed, so that what follows it in a notebook is not swallowed.
    page = ElementTree.fromstring(shown)
    rows = [["".join(cell.itertext()) for cell in row] for row in page.iter("tr")]
    assert rows[0] == ["16 states", "least", "largest", "unit", "measurement error"]
    assert rows[1] == ["Axial strain", "0", "12", "%", "control"]
    assert rows[2] == ["Stress ratio σ1/σ3", "1", "2.2", "", "sd 0.01, 0.5 % of each value, noise of sd 0.002"]
    assert rows[3] == ["Volumetric strain", "-1.2", "0", "%", "steps of 0.01 %"]
    assert [item.text for item in page.iter("li")] == ["column 'a' < b"]
    (drawn,) = page.iter("{http://www.w3.org/2000/svg}svg")
    said = ElementTree.tostring(drawn, encoding="unicode")
    assert sum(group.get("id", "").startswith("axes_") for group in drawn.iter("{http://www.w3.org/2000/svg}g")) == 3
    # Okabe and Ito's blue.
    assert "#0072b2" in said


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", "a$b", "50 % & more", "x_{1}"])
def test_whatever_is_a_name_is_text(name):
    shown = gc.Reference(STRAIN, {name: STRAIN}, notes=(f"note {name}",))._repr_html_()
    assert "<script" not in shown
    page = ElementTree.fromstring(shown)
    assert [item.text for item in page.iter("li")] == [f"note {name}"]


def test_compression_is_drawn_over_the_logarithm_of_the_stress_and_many_rows_as_a_line():
    stress = np.geomspace(1e4, 1e6, 100)
    shown = gc.Reference(stress, {"void_ratio": 0.7 - 0.01 * np.log(stress)}, control_name="axial_stress")._repr_html_()
    ElementTree.fromstring(shown)
    assert "PathCollection" not in shown and "PathCollection" in drained()._repr_html_()
    # The ticks of a logarithmic axis.
    assert "<!-- 10 -->" in shown and "<!-- 1000 -->" in shown


def test_a_space_shows_its_ranges_with_their_units():
    space = gc.ParameterSpace({"E": (1e6, 1e9), "phi": (0, 60), "nu": 0.2}, {"E": "Pa", "phi": "deg"}, ["phi"], scale={"E": "log"}, constraints=["phi < E"])
    assert repr(space).splitlines() == [
        "ParameterSpace: 2 unknown parameters",
        "  E    1e+06 to 1e+09 Pa, even in the logarithm",
        "  phi  0 to 60 deg, a value in each experiment",
        "  nu   0.2, fixed",
        "  where phi < E",
    ]
    assert "φ" in space._repr_html_() and "0 to 60 deg" in space._repr_html_() and "phi &lt; E" in space._repr_html_()
    assert repr(gc.Samples(np.arange(3), np.zeros((3, 2)), ("E", "phi"))) == "Samples(3 of E, phi)"


def test_a_stress_path_says_its_packing_and_its_pressure():
    test = gc.TriaxialTest(packing(), confining_pressure=0.5e6, fixed={"nu": 0.2})
    assert repr(test).startswith("TriaxialTest(Packing(500 particles") and repr(test).endswith(" at 500 kPa, law linear, nu = 0.2)")
    other = gc.OedometricTest(packing(), confining_pressure=20e3)
    assert repr(other).startswith("OedometricTest(")
