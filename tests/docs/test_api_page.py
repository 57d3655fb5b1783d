"""The page of Python: an example for every public name, and every example runs."""

import doctest
import re
from pathlib import Path

import graincal

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "api.md"


def test_the_examples_of_the_page_run():
    ran = doctest.testfile(str(PAGE), module_relative=False)
    assert ran.attempted > 0 and ran.failed == 0


def test_every_public_name_has_an_example():
    examples = "\n".join(example.source for example in doctest.DocTestParser().get_examples(PAGE.read_text()))
    # A name that a result brings is not called by hand.
    brought = {"Result": "gc.calibrate(", "Response": "gc.simulate("}
    missing = [name for name in graincal.__all__ if not (re.search(rf"\bgc\.{name}\b", examples) or brought.get(name, "\0") in examples)]
    assert missing == []
