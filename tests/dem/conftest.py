import pytest

from graincal.models.economy import PRECISIONS

from .spheres import packing_at_rest


@pytest.fixture(scope="session")
def packing():
    """A hundred grains at rest under 100 kPa with a modulus of 1 GPa."""
    return packing_at_rest()


@pytest.fixture(params=PRECISIONS)
def precision(request):
    """What forces, velocities and the contacts' memory are computed in."""
    return request.param
