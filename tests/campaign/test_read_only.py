"""A campaign in a folder that can only be read, as an archive on a share: what needs no writing is done, and all else is one sentence."""

import builtins
import errno
import io
import os
import shutil
from pathlib import Path

import pytest

import graincal as gc
from graincal.cli import main

from .hyperbola import write_calibration


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("archived")
    with pytest.raises(SystemExit):
        main(["calibrate", str(write_calibration(folder, ("= 3\ns", "= 2\ns"))), "-o", str(folder / "campaign"), "--quiet"])
    return folder / "campaign"


@pytest.fixture
def archived(finished, tmp_path, monkeypatch):
    """Its folder, in which the system refuses whatever writes (a test that runs as root cannot be refused by rights)."""
    folder = shutil.copytree(finished, tmp_path / "archived")

    def refusing(call):
        def refused(path, *arguments, **options):
            writes = call not in (builtins.open, io.open) or set(str(arguments[:1]) + str(options.get("mode", ""))) & set("wax+")
            if not isinstance(path, int) and writes and Path(path).absolute().is_relative_to(folder):
                raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))
            return call(path, *arguments, **options)

        return refused

    for place, name in ((builtins, "open"), (io, "open"), (os, "mkdir"), (os, "unlink"), (os, "replace")):
        monkeypatch.setattr(place, name, refusing(getattr(place, name)))
    return folder


SAID = "this cannot be written (Read-only file system): name another place, as by -o, or copy the folder to where it may be written.\n"


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["report"], "report.html"),
        (["report", "--figures", "png"], "figures/"),
        (["resume"], "report.html"),
        (["resume", "--max-iterations", "3"], "log.txt"),
        (["export", "--to", "csv"], "export"),
        (["export", "--to", "json"], "export"),
    ],
)
def test_what_has_to_be_written_is_named_in_one_sentence(call, archived, arguments, named):
    called = call(arguments[0], archived, *arguments[1:])
    assert called.code == 1 and called.err.startswith(f"{archived / named}") and called.err.endswith(SAID) and called.err.count("\n") == 1


def test_what_needs_no_writing_there_is_done(call, archived, tmp_path):
    before = sorted(archived.rglob("*"))
    assert call("status", archived).code == 0 and call("status", archived, "--json").code == 0
    assert call("report", archived, "-o", tmp_path / "report.html").code == 0 and (tmp_path / "report.html").exists()
    assert call("export", archived, "--to", "csv", "-o", tmp_path / "export").code == 0
    assert gc.Result.read(archived).evaluations == 40
    assert sorted(archived.rglob("*")) == before


def test_python_says_the_same(archived):
    with pytest.raises(gc.FolderError, match="report.html: this cannot be written"):
        gc.Result.read(archived).report(archived / "report.html")
