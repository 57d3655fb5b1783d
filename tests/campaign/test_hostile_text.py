"""Names and messages of somebody's: whatever they hold, no command ends in a traceback, and nothing of them that a terminal obeys reaches it."""

import json
import shutil
import unicodedata

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Calibration, Experiment, begin
from graincal.campaign.file.examination import examine

from .hyperbola import STRAIN, reference, respond, write_calibration

HOSTILE = "x\x1b[2J\x1b[31mRED\x9b1m\u202ea\nb</script>$\\frac$"


def hostile(theta):
    """What any function may raise and return."""
    if theta[0] > 0.6:
        raise FileNotFoundError(f"{HOSTILE}\udce9.dat" + "y" * 5_000_000)
    if theta[1] > 0.6:
        return gc.Failure(HOSTILE, f"{HOSTILE}\udce9", {HOSTILE: float("nan")})
    return respond(theta) | {f"z {HOSTILE}\udce9": STRAIN, "": STRAIN, f"z {HOSTILE}\ud800": STRAIN, "\x00": STRAIN}


def calibration(method="iterative-bayesian", **options):
    space = gc.ParameterSpace({f"strength {HOSTILE}": (0, 1), "dilatancy": (0, 1)}, {"dilatancy": HOSTILE})
    experiment = Experiment(f"drained {HOSTILE}", gc.PythonModel(hostile), reference())
    stop = gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=2)
    return Calibration(space, [experiment], method, options, stop, workers=2)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A campaign as a version begins one that does not look at names."""
    folder = tmp_path_factory.mktemp("hostile") / "campaign"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Calibration, "check_names", lambda self: None)
        begin(calibration(alpha=10), folder)
    return folder


def obeyed(text):
    """Characters that a terminal does something by, or does not show."""
    return {char for char in text if unicodedata.category(char) in ("Cc", "Cf", "Cs")} - {"\n"}


@pytest.mark.parametrize(
    "arguments", [["status"], ["status", "--json"], ["export", "--to", "csv"], ["export", "--to", "json"], ["report", "--figures", "png"], ["resume"]]
)
def test_no_command_prints_what_a_terminal_obeys(call, campaign, tmp_path, arguments, recwarn):
    folder = shutil.copytree(campaign, tmp_path / "campaign")
    called = call(arguments[0], folder, *arguments[1:])
    if arguments == ["resume"]:
        # At its end: the function is not needed any more.
        assert "Stopped by" in called.out
    assert called.code == 0 and not obeyed(called.out + called.err) and "Traceback" not in called.err, called.err
    assert not [each for each in recwarn if "Glyph" in str(each.message)]
    if "--json" in arguments:
        assert json.loads(called.out)["parameters"][0] == f"strength {HOSTILE}"


def test_files_of_a_campaign_hold_one_line_for_each(call, campaign, tmp_path):
    log = (campaign / "log.txt").read_text()
    assert not obeyed(log) and max(map(len, log.splitlines())) < 4_100
    assert all(line[:2] == "20" for line in log.splitlines())
    folder = shutil.copytree(campaign, tmp_path / "campaign")
    call("report", folder)
    page = (folder / "report.html").read_text()
    assert "</script>$" not in page and not {"\x1b", "\x9b", "\u202e"} & set(page)
    call("export", folder, "--to", "json")
    json.loads((folder / "export" / "campaign.json").read_text())


def test_failures_and_further_quantities_are_kept_printable(campaign):
    result = gc.Result.read(campaign)
    kinds = {kind: reason for kind, reason, _ in result.failure_kinds()}
    assert (
        set(kinds) == {"error", "x\\x1b[2J\\x1b[31mRED\\x9b1m\\u202ea_b</script>$\\frac$"}
        and len(kinds["error"]) <= 1000
        and "(test_hostile_text.py, line" in kinds["error"]
    )
    response = next(outcome for id in result.ids if isinstance(outcome := result.response(int(id)), gc.Response))
    assert list(response.values) == [
        "stress_ratio",
        "volumetric_strain",
        "void_ratio",
        "z x\\x1b[2J\\x1b[31mRED\\x9b1m\\u202ea b</script>$\\frac$\\udce9",
        "z x\\x1b[2J\\x1b[31mRED\\x9b1m\\u202ea b</script>$\\frac$\\ud800",
        "\\x00",
    ]


@pytest.mark.parametrize("change", ["experiment", "parameter", "unit", "quantity"])
def test_python_refuses_names_that_cannot_be_shown(change):
    names = dict.fromkeys(("experiment", "parameter", "quantity"), "a") | {"unit": "-"} | {change: "a\x1b[2J"}
    space = gc.ParameterSpace({names["parameter"]: (0, 1)}, {names["parameter"]: names["unit"]})
    measured = gc.Reference(STRAIN, {names["quantity"]: STRAIN})
    with pytest.raises(gc.InputError, match=rf"the name of an? {change} must be printable text of at most 1000 characters, not \"a\\x1b\[2J\"\."):
        begin(Calibration(space, [Experiment(names["experiment"], gc.PythonModel(lambda theta: {names["quantity"]: STRAIN}), measured)]))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"drained"', '"x\\u001b[2J"', 'experiment "x\\x1b[2J": name must be printable text of at most 500 characters, not "x\\u001b[2J".'),
        ('"drained"', '"a\\nb"', 'experiment "a b": name must be printable text of at most 500 characters, not "a\\nb".'),
        ("strength  =", '"a\\u202eb" =', 'parameters must have names of printable text, of at most 500 characters, not "a\\u202eb".'),
        ("strength  =", '"" =', 'parameters must have names of printable text, of at most 500 characters, not "".'),
        ('unit = "-"', 'unit = "\\u200b"', 'parameters.dilatancy.unit must be printable text of at most 500 characters, not "\\u200b".'),
        (
            "volumetric_strain =",
            '"a\\u009b" =',
            'experiment "drained": observables must have names of printable text, of at most 500 characters, not "a\\u009b".',
        ),
        ("alpha = 10", '"al\\u001bpha" = 10', "filter.al\\x1bpha is not a key that is known here"),
        ('"reference.csv"', '"a\\u001b.csv"', "a\\x1b.csv: there is no such file, and a laboratory file was expected here."),
    ],
)
def test_a_calibration_file_is_refused_in_one_sentence(call, tmp_path, old, new, said):
    called = call("check", write_calibration(tmp_path, (old, new)))
    assert called.code == 1 and said in called.err and called.err.count("\n") == 1 and not obeyed(called.err)


def test_what_a_laboratory_file_says_is_shown_printable(call, tmp_path):
    header = 'axial_strain,"deviator\x1b[2J\u202e stress [kPa]",volumetric_strain'
    rows = "\n".join(f"{strain:g},{100 * strain:g},{strain / 10:g}" for strain in STRAIN)
    file = tmp_path / "lab\x1b[31m.csv"
    file.write_text(f"Sample \x1b[2J\u202e {'z' * 5000}\n{header}\n{rows}\n{'9' * 5000},1,1\n", encoding="utf-8")
    called = call("init", file, "--encoding", "utf-8", "--strain", "logarithmic", "-o", tmp_path / "calibration.toml")
    assert not obeyed(called.out + called.err) and "Traceback" not in called.err and len(called.out + called.err) < 5000
    if (proposed := tmp_path / "calibration.toml").exists():
        assert not obeyed(proposed.read_text())
    examined = call("check", tmp_path / "calibration.toml")
    assert not obeyed(examined.out + examined.err) and "Traceback" not in examined.err


def test_a_folder_whose_name_is_not_in_utf_8_holds_a_campaign(call, tmp_path):
    folder = tmp_path / "caf\udce9"
    folder.mkdir()
    file = write_calibration(folder, ("= 3\ns", "= 1\ns"))
    for arguments in (
        ["check", file],
        ["calibrate", file, "-o", folder / "campaign"],
        ["status", folder / "campaign"],
        ["resume", folder / "campaign", "--max-iterations", "2"],
        ["report", folder / "campaign"],
        ["export", folder / "campaign", "--to", "json"],
    ):
        called = call(*arguments)
        assert called.code == 0 and not obeyed(called.out + called.err), called.err
    refused = call("init", folder / "reference.csv", "-o", tmp_path / "calibration.toml")
    assert (
        refused.code == 1
        and "caf\\udce9/reference.csv: this name is not in UTF-8, as all text of a calibration file is, and another name was expected." in refused.err
    )


def test_figures_are_drawn_with_any_name(call, tmp_path, recwarn):
    file = write_calibration(tmp_path, ('"drained"', '"内摩擦角 $\\\\frac$ \U0001f600"'))
    call("check", file, "--plot", tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 0 and not [each for each in recwarn if "Glyph" in str(each.message)]
    assert examine(file).experiments[0].name.startswith("内摩擦角") and np.isfinite(STRAIN).all()
