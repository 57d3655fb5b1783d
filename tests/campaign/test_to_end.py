"""The time to the end is never said to be shorter than that of the round under way."""

from graincal.campaign.found.to_end import ToEnd


def test_the_end_comes_no_sooner_than_that_of_the_round_under_way():
    assert ToEnd(20.0, 52.0).no_sooner(180.0) == ToEnd(180.0, 180.0)
    assert ToEnd(None, 500.0).no_sooner(180.0) == ToEnd(None, 500.0)
