"""What is said of the void ratio of a packing."""

from graincal.cli.preparing import said_of_loose
from graincal.dem.preparation import Reach


def test_about_the_loosest_packing_is_said_to_be_no_dense_sand():
    reach = Reach(0.527, 0.750, 400)
    assert said_of_loose(reach, 0.60) == ""
    said = said_of_loose(reach, 0.748)
    assert "a relative density of 1 %" in said and "--relative-density VALUE" in said
    # Within what a packing is settled for it may be looser than that.
    assert "a relative density of 0 %" in said_of_loose(reach, 0.752)
