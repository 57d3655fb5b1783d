"""The names of experiments in those of files: what a file system takes, and another one for another experiment."""

import pytest

from graincal import Result
from graincal.campaign.asked.file_names import file_name

from .hyperbola import write_calibration


@pytest.mark.parametrize("name", ["drained", "0.5 MPa", "内摩擦角", "a" * 110])
def test_a_short_name_stays(name):
    assert file_name(name) == name.replace(" ", "_")


def test_long_names_are_cut_and_stay_different():
    names = [prefix + "n" * length + last for prefix in ("", "内摩擦角" * 40) for length in (111, 240, 500) for last in ("", "a", "b", ".", "内")]
    found = [file_name(name) for name in names]
    assert len(set(found)) == len(names)
    assert all(len(each.encode()) <= 110 and each == each.strip("_.") for each in found)
    # With what stands before and behind it, within the narrowest limit that is known.
    assert max(len(f"responses_{each}.csv".encode()) for each in found) < 143 and max(len(f"{each}_most_probable.csv".encode()) for each in found) < 143


def test_a_campaign_of_experiments_with_long_names_is_run_reported_and_exported(call, tmp_path):
    name = "n" * 249
    file = write_calibration(tmp_path, ('"drained"', f'"{name}"'), ("= 3\ns", "= 1\ns"))
    second = "\n[[experiment]]" + file.read_text().split("[[experiment]]")[1].split("[filter]")[0].replace(name, f"{name}m")
    file.write_text(file.read_text().replace("[filter]", f"{second}\n[filter]"))
    campaign = tmp_path / "campaign"
    assert call("calibrate", file, "-o", campaign, "-q").code == 0
    assert len(list((campaign / "curves").iterdir())) == 4 and call("export", campaign, "--to", "csv").code == 0
    assert len(list((campaign / "export").glob("responses_*"))) == 2
    assert [each.name for each in Result.read(campaign).experiments] == [name, f"{name}m"]
