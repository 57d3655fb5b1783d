"""Signals that ask a campaign to end, by a batch system or a logout: it ends as after Ctrl-C."""

import os
import signal
import time
from pathlib import Path

import pytest

from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store, holds_campaign

from .test_command_line import start


def wait_until_it_runs(folder: Path) -> None:
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (holds_campaign(folder) and status(folder)["evaluations"]):
        time.sleep(0.1)
    assert status(folder)["state"] == "running"


def descendants(pid: int) -> list[int]:
    found = []
    for each in Path("/proc").iterdir():
        try:
            if each.name.isdecimal() and int((each / "stat").read_text().rsplit(")", 1)[1].split()[1]) == pid:
                found += [int(each.name), *descendants(int(each.name))]
        except OSError:
            continue
    return found


def lives(pid: int) -> bool:
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("to_all", [False, True])
def test_it_ends_as_after_ctrl_c(tmp_path, number, to_all):
    process = start(tmp_path, 0.3)
    folder = tmp_path / "campaign"
    wait_until_it_runs(folder)
    others = descendants(process.pid)
    assert others
    # A batch system tells every process of a job.
    for pid in (*(others if to_all else ()), process.pid):
        os.kill(pid, number)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 128 + number
    assert err == f"Stopped. All that was finished is stored; go on with:\n  graincal resume {folder}\n"
    assert (folder / "log.txt").read_text().splitlines()[-1].endswith(f"Breaks off: ended by {number.name}")
    found = status(folder)
    assert found["state"] == "interrupted" and not Store.open(folder).failure_kinds()
    # Python's own helper ends when it sees that it has no owner any more.
    deadline = time.monotonic() + 10
    while any(map(lives, others)) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not any(map(lives, others))


def test_a_logout_does_not_end_what_is_begun_by_nohup(tmp_path):
    process = start(tmp_path, 0.05, "-q", preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    wait_until_it_runs(tmp_path / "campaign")
    process.send_signal(signal.SIGHUP)
    assert process.wait(timeout=60) == 0 and status(tmp_path / "campaign")["state"] == "finished"


def test_the_sentence_is_not_needed_where_the_terminal_is_gone(tmp_path):
    process = start(tmp_path, 0.3)
    wait_until_it_runs(tmp_path / "campaign")
    process.stdout.close()
    process.stderr.close()
    process.send_signal(signal.SIGHUP)
    assert process.wait(timeout=30) == 129
    assert "Breaks off: ended by SIGHUP" in (tmp_path / "campaign" / "log.txt").read_text()
