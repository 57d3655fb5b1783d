"""The code of a named function, changed between two sittings of a campaign: it is said that its evaluations may be those of two models."""

import json
import shutil

import pytest

import graincal as gc
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.status import status
from graincal.campaign.stored.code import CODE, digests_of
from graincal.campaign.stored.store import Store
from graincal.cli import main

from .hyperbola import write_calibration

REMARK = "this code was changed since the campaign was begun"


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    """A campaign of a function whose module imports another one from beside itself, and that has ended by a limit."""
    folder = tmp_path_factory.mktemp("code")
    file = write_calibration(folder, ('"soil:respond"', '"model:respond"'), ("= 3\ns", "= 1\ns"))
    (folder / "model.py").write_text("import numpy\nfrom soil import respond as soil\n\ndef respond(theta):\n    return soil(theta)\n")
    (folder / "unrelated.py").write_text("")
    with pytest.raises(SystemExit):
        main(["calibrate", str(file), "-o", str(folder / "campaign"), "--quiet"])
    return folder


@pytest.fixture
def folder(begun, tmp_path):
    copied = shutil.copytree(begun, tmp_path / "copied")
    # The store names the folder that the module is looked for in.
    store = Store.open(copied / "campaign")
    with store._transaction() as db:
        db.execute("UPDATE meta SET value = replace(value, ?, ?)", (str(begun), str(copied)))
    store.close()
    return copied


def test_digests_are_of_the_module_and_of_what_it_imports_from_beside_itself(begun):
    assert list(digests_of(read_calibration(begun / "calibration.toml"))) == ["model.py", "soil.py"]
    assert list(json.loads(Store.open(begun / "campaign").meta(CODE))) == ["model.py", "soil.py"]


def test_code_that_is_as_it_was_is_not_mentioned(call, folder):
    (folder / "unrelated.py").write_text("changed")
    called = call("resume", folder / "campaign", "--max-iterations", "2")
    assert called.code == 0 and REMARK not in called.out and gc.Result.read(folder / "campaign").code_changed is None


@pytest.mark.parametrize("name", ["model.py", "soil.py"])
def test_code_that_was_changed_is_said_everywhere(call, folder, name):
    (folder / name).write_text((folder / name).read_text() + "\n# Changed.\n")
    campaign = folder / "campaign"
    called = call("resume", campaign, "--max-iterations", "2")
    assert called.code == 0 and f"{name}: {REMARK}" in " ".join(called.out.split())
    assert f"{name}: {REMARK}" in (campaign / "log.txt").read_text()
    (said,) = [each for each in status(campaign)["remarks"] if each["code"] == "code-changed"]
    assert said["numbers"] == {"files": [name]} and said["text"] in (campaign / "report.html").read_text()
    # Changed back, it is still a campaign of two models.
    (folder / name).write_text((folder / name).read_text().removesuffix("\n# Changed.\n"))
    assert REMARK not in call("resume", campaign, "--max-iterations", "3").out and gc.Result.read(campaign).code_changed == name


def test_a_campaign_of_before_goes_on_and_keeps_what_it_finds(call, folder):
    campaign = folder / "campaign"
    store = Store.open(campaign)
    with store._transaction() as db:
        db.execute("DELETE FROM meta WHERE key = ?", (CODE,))
    store.close()
    assert REMARK not in call("resume", campaign, "--max-iterations", "2").out
    (folder / "soil.py").write_text((folder / "soil.py").read_text() + "\n# Changed.\n")
    assert REMARK in " ".join(call("resume", campaign, "--max-iterations", "3").out.split())


def test_code_that_is_no_python_is_known_by_itself(tmp_path):
    file = write_calibration(tmp_path)
    calibration = read_calibration(file)
    (tmp_path / "soil.py").write_bytes(b"import nothing\n(\xff" + b"(" * 5000)
    assert list(digests_of(calibration)) == ["soil.py"]
