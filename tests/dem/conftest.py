import pytest

from .spheres import packing_at_rest


@pytest.fixture(scope="session")
def packing():
    """A hundred grains at rest under 100 kPa with a modulus of 1 GPa."""
    return packing_at_rest()
