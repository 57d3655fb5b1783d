"""Stress, unbalanced force, energies and fabric against straightforward sums over the contacts."""

import numpy as np
import pytest

from graincal import _native
from graincal.models.economy import PRECISIONS

from .spheres import STILL, jittered_lattice, law, masses, normal_stiffness, rounding, steps, two_spheres

DENSITY = 1.0
STIFFNESS_RATIO, BETA = 0.3, 0.2


def exact(precision):
    """The same sums in another order, of terms that round in the precision."""
    return 1e-12 + 20 * rounding(precision)


COMPRESSED_ALONG_Z = np.diag([1.0, 1.0, -4.0])
EXTENDED_ALONG_Z = np.diag([-1.5, -1.5, 3.0])


def sheared_packing(gradient, precision, seed=1):
    """A lattice of unequal spheres with rattlers, sheared for a while and then stopped: springs of all kinds are loaded, some contacts slide."""
    positions, radii, edges = jittered_lattice(side=5, spacing=1.9, seed=seed)
    generator = np.random.default_rng(seed)
    radii = np.where(generator.uniform(size=len(radii)) < 0.15, 0.55 * radii, radii)  # these touch little or nothing
    edges = np.ascontiguousarray(edges @ np.array([[1, 0.1, 0], [0, 1, 0], [0.1, 0, 1]]))
    positions = np.ascontiguousarray(positions @ (edges @ np.linalg.inv(np.diag(np.diag(edges)))).T)
    friction, strength = 0.3, 0.2
    simulation = _native.Simulation(positions, radii, edges, law(1e7, STIFFNESS_RATIO, friction, BETA, strength), DENSITY, precision=precision)
    simulation.set_spins(generator.normal(0, 5, positions.shape))
    steps(simulation, 400, 3e-5, gradient, damping=0.3)
    steps(simulation, 1, 3e-5, STILL)  # stress and contacts are those of the force pass, the cell does not move after it
    return simulation


@pytest.fixture(scope="module", params=PRECISIONS)
def precision(request):
    return request.param


@pytest.fixture(scope="module", params=[COMPRESSED_ALONG_Z, EXTENDED_ALONG_Z], ids=["compressed", "extended"])
def simulation(request, precision):
    return sheared_packing(request.param, precision)


@pytest.fixture(scope="module")
def contacts(simulation):
    columns = simulation.contacts()
    radii = simulation.radii
    r1, r2 = radii[columns["first"]], radii[columns["second"]]
    columns["kn"] = normal_stiffness((r1, r2))
    columns["ks"] = STIFFNESS_RATIO * columns["kn"]
    columns["km"] = BETA * r1 * r2 * columns["ks"]
    columns["branch"] = (r1 + r2 - columns["overlap"])[:, None] * columns["normal"]
    columns["normal_force"] = np.sum(columns["force"] * columns["normal"], axis=1)
    return columns


def test_the_packing_has_all_that_the_formulas_speak_of(simulation, contacts):
    touching = np.bincount(np.concatenate([contacts["first"], contacts["second"]]), minlength=len(simulation.radii))
    assert np.sum(touching == 0) > 2 and np.sum(touching == 1) > 2
    sliding = np.isclose(np.linalg.norm(contacts["shear"], axis=1), 0.3 * contacts["normal_force"])
    assert 0.1 < sliding.mean() < 0.9
    assert np.all(np.linalg.norm(contacts["bending"], axis=1) > 0)
    # What the turned memory of shear has along the normal is small: kn times overlap is the force's normal component.
    assert np.allclose(contacts["normal_force"], contacts["kn"] * contacts["overlap"], rtol=0, atol=1e-3 * contacts["normal_force"].max())


def test_stress_is_the_sum_of_force_times_branch_over_the_volume(simulation, contacts, precision):
    expected = np.einsum("ca,cb->ab", contacts["force"], contacts["branch"]) / np.linalg.det(simulation.edges)
    assert np.allclose(simulation.stress, expected, rtol=0, atol=exact(precision) * np.abs(expected).max())
    assert np.allclose(simulation.stress_diagonal[0], np.diag(expected), rtol=exact(precision), atol=0)
    assert np.all(np.diag(expected) > 0)  # compression positive


def test_unbalanced_force_is_mean_resultant_over_mean_contact_force(simulation, contacts, precision):
    resultants = np.zeros((len(simulation.radii), 3))
    np.add.at(resultants, contacts["second"], contacts["force"])
    np.add.at(resultants, contacts["first"], -contacts["force"])
    expected = np.linalg.norm(resultants, axis=1).mean() / np.linalg.norm(contacts["force"], axis=1).mean()
    assert simulation.unbalanced_force == pytest.approx(expected, rel=exact(precision))


def test_energies(simulation, contacts, precision):
    mass = masses(simulation.radii, DENSITY)
    inertia = 0.4 * mass * simulation.radii**2
    kinetic = 0.5 * np.sum(mass * np.sum(simulation.velocities**2, axis=1) + inertia * np.sum(simulation.spins**2, axis=1))
    assert simulation.kinetic_energy == pytest.approx(kinetic, rel=exact(precision))
    # Bending and twisting have one stiffness: the springs' energy is that of the whole moment.
    moment = contacts["bending"] + contacts["twisting"]
    springs = ((contacts["kn"], contacts["overlap"][:, None]), (1 / contacts["ks"], contacts["shear"]), (1 / contacts["km"], moment))
    elastic = 0.5 * sum(np.sum(stiffness * np.sum(vectors**2, axis=1)) for stiffness, vectors in springs)
    assert simulation.elastic_energy == pytest.approx(elastic, rel=exact(precision))


def test_springs_that_are_not_there_hold_no_energy(precision):
    simulation = two_spheres(overlap=0.01, stiffness_ratio=0.0, rolling_stiffness=0.0, precision=precision)
    steps(simulation, 1)
    assert simulation.elastic_energy == pytest.approx(0.5 * normal_stiffness((1.0, 0.7)) * 1e-4, rel=1e-11 + 10 * rounding(precision))


def test_void_ratio_counts_whole_spheres(simulation, precision):
    solid = 4 / 3 * np.pi * np.sum(simulation.radii**3)
    assert simulation.void_ratio == pytest.approx(np.linalg.det(simulation.edges) / solid - 1, rel=exact(precision))


# Fabric: Hartmann, Cheng, Thornton (2022), Eq. 8-11


def deviator(tensor):
    return tensor - np.trace(tensor) / 3 * np.eye(3)


def signed(tensor, stress):
    return np.sign(np.sum(tensor * deviator(stress))) * np.sqrt(1.5 * np.sum(tensor**2))


def test_mechanical_coordination_number_leaves_out_who_carries_nothing(simulation, contacts, precision):
    # Eq. 8: Z = (2 C - N1) / (N - N0 - N1)
    touching = np.bincount(np.concatenate([contacts["first"], contacts["second"]]), minlength=len(simulation.radii))
    carrying = touching >= 2
    assert simulation.fabric()["coordination_number"] == pytest.approx(touching[carrying].sum() / carrying.sum(), rel=exact(precision))
    assert simulation.fabric()["contacts"] == len(contacts["first"])


def test_anisotropies_of_normals_and_forces(simulation, contacts, precision):
    n, force = contacts["normal"], contacts["force"]
    a_c = 7.5 * deviator(np.mean(n[:, :, None] * n[:, None, :], axis=0))
    density = 1 + np.einsum("ca,ab,cb->c", n, a_c, n)
    shear = np.linalg.norm(contacts["shear"], axis=1)
    direction = contacts["shear"] / shear[:, None]
    chi_n = np.mean((contacts["normal_force"] / density)[:, None, None] * n[:, :, None] * n[:, None, :], axis=0)
    chi_t = np.mean((shear / density)[:, None, None] * direction[:, :, None] * n[:, None, :], axis=0)
    a_n, a_t = 7.5 * deviator(chi_n) / np.trace(chi_n), 5 * deviator(chi_t) / np.trace(chi_n)
    stress = np.einsum("ca,cb->ab", force, contacts["branch"])
    fabric = simulation.fabric()
    for name, tensor in {"a_c": a_c, "a_n": a_n, "a_t": a_t}.items():
        assert fabric[name] == pytest.approx(signed(tensor, stress), rel=1e-9 + 20 * rounding(precision)), name


def test_contacts_that_face_the_larger_stress_make_a_positive_anisotropy(simulation):
    # The sign is that against the stress, so it is positive in compression and in extension alike.
    assert simulation.fabric()["a_c"] > 0


def test_without_contacts_there_is_no_fabric(precision):
    simulation = two_spheres(overlap=-0.1, precision=precision)
    steps(simulation, 1)
    assert simulation.fabric() == {"coordination_number": 0, "a_c": 0, "a_n": 0, "a_t": 0, "contacts": 0}
    assert np.array_equal(simulation.stress, np.zeros((3, 3)))
