"""The contact laws are declared once, and what names them elsewhere follows."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import graincal as gc
from graincal.cli import app
from graincal.models.contact_laws import LAWS, check_ranges

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_documents_and_the_command_line_name_each_law_and_parameter(law) -> None:
    laws, keys = ((DOCS / name).read_text() for name in ("contact-laws.md", "calibration-file.md"))
    shown = CliRunner().invoke(app, ["simulate", "triaxial", "--help"], env={"COLUMNS": "200"}).output
    assert f'`"{law.name}"`' in laws and f'`"{law.name}"`' in keys and law.name in shown
    assert all(f"| `{parameter.name}` |" in laws and f"| `{parameter.name}`" in keys for parameter in law.parameters)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_documents_say_the_bounds_of_each_parameter(law) -> None:
    lines = {line.split("|")[1].strip(" `"): line for line in (DOCS / "contact-laws.md").read_text().splitlines() if line.startswith("| `")}
    for parameter in law.parameters:
        assert all(f"{bound:g}" in lines[parameter.name] for bound in (parameter.low, parameter.high) if bound < 1e9)


@pytest.mark.parametrize(("given", "key"), [((0, 0.6), "range"), (0.5, "fixed")])
def test_a_bound_of_one_law_alone_is_said_with_its_name(given, key):
    parameters = gc.ParameterSpace({"log_E": (7, 11), "nu": given, "phi": (0, 60)})
    check_ranges(parameters, "linear")
    with pytest.raises(
        gc.InputError,
        match=rf'parameters\.nu\.{key} must .*at least 0 and below 0\.5, where the contact law "hertz-mindlin" means something \(nu is Poisson\'s ratio ν of the grains there\)',
    ):
        check_ranges(parameters, "hertz-mindlin")
