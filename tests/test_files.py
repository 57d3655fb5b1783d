"""Files that cannot be read or written are said with what failed, and with what was expected."""

import pytest

from graincal.campaign.stored.trouble import FolderError
from graincal.files import unreadable, unwritable


def error_of(act):
    with pytest.raises(OSError) as caught:
        act()
    return caught.value


def test_what_kept_a_file_from_being_read_is_said(tmp_path):
    missing = tmp_path / "lab.csv"
    assert (
        unreadable(missing, error_of(missing.read_text), "a laboratory file") == f"{missing}: there is no such file, and a laboratory file was expected here."
    )
    assert unreadable(tmp_path, error_of(tmp_path.read_text), "a laboratory file") == f"{tmp_path}: this is a folder, and a laboratory file was expected here."


def test_what_kept_a_file_from_being_written_is_said(tmp_path):
    lost, file = tmp_path / "none" / "curve.csv", tmp_path / "file"
    file.write_text("")
    no_folder = f"{lost}: this cannot be written, for there is no folder {lost.parent}, and one that exists was expected."
    assert unwritable(lost, error_of(lambda: lost.write_text(""))) == no_folder == str(FolderError.of(lost, error_of(lambda: lost.write_text(""))))
    assert unwritable(tmp_path, error_of(lambda: tmp_path.write_text(""))) == f"{tmp_path}: this is a folder, and the name of a file to write was expected."
    assert unwritable(file, error_of(file.mkdir)) == f"{file}: this is a file, and a folder to write to was expected."
    below = file / "below"
    assert unwritable(below, error_of(below.mkdir)) == f"{below}: this cannot be written, for there is no folder {file}, and one that exists was expected."
