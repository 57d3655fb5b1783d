"""Sizes that would fill the memory or never come to an end, and texts that TOML's reader stumbles over: a sentence with the key and the limit, before anything is made of them."""

import pytest

import graincal as gc
from graincal.campaign.file.config import read_calibration
from graincal.notation.toml import NotTOML, read_toml

from .hyperbola import SPACE, THE_PAPERS, model, reference, write_calibration
from .test_calibration_file import write_triaxial

OF_THE_PAPER = "s = false\ngl_error_increment = false\nerror = false\nerror_increment = false\n"
FUNCTION = 'function = "soil:respond"'


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (THE_PAPERS, "first_batch = 1000000000", "filter.first_batch is 1000000000, and at most 1,000,000 was expected."),
        (THE_PAPERS, "batch = 1000000000", "filter.batch is 1000000000, and at most 1,000,000 was expected."),
        (THE_PAPERS, "ahead = 1000000000", "filter.ahead is 1000000000, and at most 100 was expected."),
        ("alpha = 10", "alpha = 1e12", "filter.alpha = 1e+12 asks for 2000000000000 samples an iteration, and at most 1000000 can be held."),
        ("workers = 1", "workers = 1000000000", "run.workers is 1000000000, and at most 10,000 was expected."),
        ("max_iterations = 3", "max_iterations = 1000000000", "stop.max_iterations is 1000000000, and at most 1,000,000 was expected."),
        ("max_iterations = 3", "max_evaluations = 1000000000", "stop.max_evaluations is 1000000000, and at most 1,000,000 was expected."),
        (FUNCTION, f"{FUNCTION}, timeout = 1e300", 'experiment "drained": model.timeout is 1e+300, and at most 1e+08 was expected.'),
        (
            FUNCTION,
            f"{FUNCTION}, control = [{'1, ' * 100_000}1]",
            'experiment "drained": model.control has 100001 elements, and at most 100,000 were expected.',
        ),
        ("range = [0, 1] }", "range = [-1e308, 1e308] }", "parameters.strength: range must be [low, high] with finite low < high, not [-1e+308, 1e+308]."),
        (
            "seed = 3",
            "seed = 9223372036854775808",
            "this is not TOML, a number in it has more digits than a whole number may have, and up to 9223372036854775807 was expected.",
        ),
        (
            "seed = 3",
            f"seed = {'9' * 5000}",
            "this is not TOML, a number in it has thousands of digits, and whole numbers up to 9223372036854775807 were expected.",
        ),
        (
            "seed = 3",
            f"seed = 0x{'f' * 5000}",
            "this is not TOML, a number in it has more digits than a whole number may have, and up to 9223372036854775807 was expected.",
        ),
        ("seed = 3", f"seed = {'[' * 5000}", "this is not TOML, tables or lists within each other are more than 20."),
        ("seed = 3", f"seed = {'[' * 50}{']' * 50}", "this is not TOML, tables or lists within each other are more than 20."),
        ("seed = 3", f"{'a.' * 3000}a = 3", "this is not TOML, tables or lists within each other are more than 20."),
    ],
)
def test_a_calibration_file_names_the_key_and_the_limit(tmp_path, old, new, said):
    file = write_calibration(tmp_path, (old, new), *([(OF_THE_PAPER, "")] if old == THE_PAPERS else []))
    with pytest.raises(gc.InputError) as refused:
        read_calibration(file)
    assert str(refused.value) == f"{file}: {said}"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('packing = "cubic.csv"', "particles = 1000000000, void_ratio = 0.7", "model.particles is 1000000000, and at most 1,000,000 was expected."),
        ('packing = "cubic.csv"', "particles = 1000, void_ratio = 1e9", "model.void_ratio is 1000000000.0, and at most 100 was expected."),
        ('packing = "cubic.csv"', "packing = [" + ", ".join(['"cubic.csv"'] * 101) + "]", "model.packing has 101 elements, and at most 100 were expected."),
    ],
)
def test_so_does_that_of_a_built_in_test(tmp_path, old, new, said):
    with pytest.raises(gc.InputError, match=f'experiment "drained": {said}'):
        read_calibration(write_triaxial(tmp_path, (old, new)))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"first_batch": 10**9}, "filter.first_batch is 1000000000, and at most 1,000,000 was expected."),
        ({"ahead": 10**9}, "filter.ahead is 1000000000, and at most 100 was expected."),
        ({"workers": 10**12}, "workers is 1000000000000, and at most 10,000 was expected."),
    ],
)
def test_python_does_too(options, said):
    with pytest.raises(gc.InputError, match=said):
        gc.calibrate(model(), reference(), SPACE, **options)


@pytest.mark.parametrize("workers", ["9" * 5000, "1000000000", "٣", "-1"])
def test_so_do_options(call, tmp_path, workers):
    called = call("calibrate", write_calibration(tmp_path), "-o", tmp_path / "campaign", "--workers", workers)
    assert called.code == 1 and called.err.count("\n") == 1 and "workers" in called.err and len(called.err) < 300


def test_what_toml_holds_is_read():
    assert read_toml("a = [[[1, -9223372036854775807]]]\nb.c.d = 1e400") == {"a": [[[1, -(2**63) + 1]]], "b": {"c": {"d": float("inf")}}}
    with pytest.raises(NotTOML):
        read_toml("a = ")


@pytest.mark.parametrize("name", ["x" * 300, "a\x1b[2J", "caf\udce9"])
def test_a_name_that_no_file_has_is_a_sentence(call, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    for arguments in (
        ["status", name],
        ["report", name],
        ["resume", name],
        ["export", name, "--to", "csv"],
        ["check", name],
        ["calibrate", name, "-o", "out"],
        ["init", name],
        ["predict", name],
        ["pack", "--particles", "100", "--void-ratio", "0.7", "--grading", name],
    ):
        called = call(*arguments)
        assert called.code in (1, 2) and "Traceback" not in called.err and "\x1b[2J" not in called.err, arguments
