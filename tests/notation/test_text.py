"""Prose is broken between words, and what is to be copied is not."""

from graincal.notation.text import between_words


def test_prose_is_broken_between_words_and_goes_on_indented():
    assert between_words("The posterior has not settled.\nStored.", 16) == "The posterior\n  has not\n  settled.\nStored."
    assert between_words("  The posterior has not", 16) == "  The posterior\n    has not"


def test_what_fits_stays_as_it_is():
    assert between_words("   a    b\n", 16) == "   a    b\n"


def test_commands_and_words_longer_than_a_line_stay_whole():
    command = "  graincal resume campaign --max-evaluations 120"
    assert between_words(f"Go on with:\n{command}", 20) == f"Go on with:\n{command}"
    assert between_words("in /a/folder/with-a-very/long-name.csv", 10) == "in\n  /a/folder/with-a-very/long-name.csv"


def test_a_command_at_the_end_of_a_line_stays_whole():
    said = "this calibration was begun here before, go on with it by: graincal resume '/home/some one/a long folder'"
    *prose, command = between_words(said, 40).split("\n")
    assert command == "  graincal resume '/home/some one/a long folder'" and all(len(line) <= 40 for line in prose) and prose[-1].endswith("by:")
