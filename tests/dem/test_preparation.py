"""Packings are prepared to the void ratio asked for, whatever the size and the seed, the same each time, and kept."""

import numpy as np
import pytest

from graincal.data import InputError
from graincal.dem import preparation
from graincal.dem.grading import Grading
from graincal.dem.preparation import prepare

VOID_RATIO = 0.68
ACCEPTED = 0.002


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packings")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GRAINCAL_CACHE", str(folder))
        yield folder


# Small packings settle into few states. In these the search for the friction angle ends at one that lets them collapse past the void ratio.
@pytest.mark.slow
@pytest.mark.parametrize(("particles", "seed"), [(400, 1), (500, 1), (500, 2), (500, 4), (600, 2), (600, 5)])
def test_the_void_ratio_is_met_by_small_packings(cache, particles, seed):
    packing = prepare(particles, VOID_RATIO, seed=seed)
    assert packing.count == particles
    assert packing.void_ratio == pytest.approx(VOID_RATIO, abs=ACCEPTED)


@pytest.mark.slow
@pytest.mark.parametrize("void_ratio", [0.62, 0.72])
def test_the_void_ratio_is_met_by_dense_and_by_loose_packings(cache, void_ratio):
    assert prepare(400, void_ratio, seed=1).void_ratio == pytest.approx(void_ratio, abs=ACCEPTED)


@pytest.mark.slow
def test_a_seed_names_one_packing(cache):
    first = prepare(400, VOID_RATIO, seed=1)
    again = preparation._prepare(400, VOID_RATIO, Grading.named("toyoura"), 1)
    assert np.array_equal(first.positions, again.positions) and np.array_equal(first.edges, again.edges)
    assert not np.array_equal(first.radii, prepare(400, VOID_RATIO, seed=2).radii)


def test_what_was_prepared_is_kept(cache, monkeypatch):
    kept = prepare(400, VOID_RATIO, seed=1)
    monkeypatch.setattr(preparation, "_prepare", lambda *request: pytest.fail("prepared again"))
    assert np.array_equal(prepare(400, VOID_RATIO, seed=1).positions, kept.positions)


@pytest.mark.slow
@pytest.mark.parametrize("void_ratio", [0.3, 1.5])
def test_a_void_ratio_out_of_reach_is_refused_with_the_range(cache, void_ratio):
    with pytest.raises(InputError, match=rf"void_ratio: {void_ratio} is out of reach for grading toyoura, which packs to between 0\.\d+ and 0\.\d+\."):
        prepare(400, void_ratio, seed=1)


def test_the_built_in_toyoura_is_toyoura_sand_enlarged():
    # Its median diameter is published as 0.17 to 0.22 mm.
    grading = Grading.named("toyoura")
    assert 0.17e-3 < np.interp(50, grading.passing, grading.sizes) / grading.enlarged < 0.22e-3


def test_a_grading_of_a_median_size_and_a_coefficient_of_uniformity():
    for said in ("d50=0.14,Cu=1.5", "D50 = 0.14 mm, cu = 1.5", "d50=0.14 Cu=1.5"):
        grading = Grading.named(said)
        d10, d50, d60 = np.exp(np.interp([10, 50, 60], grading.passing, np.log(grading.sizes)))
        assert d50 == pytest.approx(0.14e-3) and d60 / d10 == pytest.approx(1.5) and grading.name == "d50=0.14,Cu=1.5"
    assert grading.sizes[[0, -1]] == pytest.approx([0.14e-3 / 1.5, 0.14e-3 * 1.5])
    # By mass, of a thousand grains that are drawn from it.
    diameters = np.sort(grading.diameters(1000, np.random.default_rng(1)))
    half = diameters[np.searchsorted(np.cumsum(diameters**3), 0.5 * np.sum(diameters**3))]
    assert half == pytest.approx(0.14e-3, rel=0.02)


@pytest.mark.parametrize("said", ["d50=0.14,Cu=1", "d50=0,Cu=1.5", "d50=-1,Cu=2", "d50=.,Cu=2", "d50=0.14,Cu=", "d50=1e999,Cu=2", "d50=x,Cu=2"])
def test_a_grading_of_a_median_size_that_is_none_is_refused(said):
    with pytest.raises(InputError, match="expected"):
        Grading.named(said)
