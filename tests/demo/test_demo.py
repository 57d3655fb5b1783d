"""The demo: what it sets itself, and the command on a part of it."""

from dataclasses import replace

import numpy as np
import pytest

from graincal import ParameterSpace, demo
from graincal.cli import main
from graincal.cli.chart import HEIGHT, chart
from graincal.inference import Stop


@pytest.fixture(scope="module")
def grains():
    return demo.packing()


def test_it_is_a_whole_calibration(grains):
    other = demo.sibling()
    calibration = demo.calibration(grains, demo.reference(other))
    # Its reference is of another packing of the same material, and what packings differ by counts.
    assert other.count == grains.count and abs(other.void_ratio - grains.void_ratio) <= 0.002 and not np.allclose(other.positions, grains.positions)
    np.testing.assert_allclose(np.sort(other.radii).sum(), np.sort(grains.radii).sum(), rtol=0.05)
    assert all(calibration.new_filter().siblings)
    assert grains.count >= 500 and abs(grains.void_ratio - 0.68) <= 0.002
    assert calibration.space.names == ParameterSpace.paper().names
    assert np.array_equal(calibration.space.low, ParameterSpace.paper().low) and np.array_equal(calibration.space.high, ParameterSpace.paper().high)
    assert calibration.experiments[0].reference.control[-1] >= 0.05
    assert calibration.method == "posterior" and calibration.check().new_filter().most_evaluations == 600
    assert all(low < demo.TRUTH[name] < high for name, low, high in zip(calibration.space.names, calibration.space.low, calibration.space.high))


def test_no_sample_can_repeat_the_reference_grain_for_grain(grains):
    model = demo.calibration(grains, demo.reference(grains)).experiments[0].model
    assert model.density_scaling != demo.REFERENCE_DENSITY_SCALING


def test_the_command_ends_with_truth_beside_estimate_and_the_report(monkeypatch, tmp_path, capsys):
    whole = demo.calibration

    def small(*arguments, **options):
        space = ParameterSpace({"log_E": (8, 8.5), "nu": (0.1, 0.5), "phi": (20, 60), "beta_m": (0, 1), "eta_m": (0, 1)})
        return replace(whole(*arguments, **options), space=space, filter_options={"first_batch": 8}, stop=Stop(max_iterations=1))

    monkeypatch.setattr(demo, "calibration", small)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graincal-demo").mkdir()
    folder = tmp_path / "graincal-demo-2"
    with pytest.raises(SystemExit) as ended:
        main(["demo"])
    out = capsys.readouterr().out
    assert not ended.value.code
    assert out.startswith("graincal-demo is there already, so this demo goes into graincal-demo-2.\n")
    assert out.index("· reference") < out.index("batch 0") < out.index("truth") < out.index("report.html")
    report = (folder / "report.html").read_text()
    assert all(f"The truth, {value:g}" in report for value in demo.TRUTH.values())


def test_a_chart_shows_both_curves_where_they_are():
    drawn = chart([0, 1], {"low": [0, 0], "high": [0, 1]}, title="t").splitlines()
    assert len(drawn) == 1 + HEIGHT + 2
    assert drawn[1].rstrip().endswith("o") and "·" not in drawn[1]
    assert "·" in drawn[HEIGHT]
