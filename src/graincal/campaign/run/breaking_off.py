"""What is said where a campaign, or the filling of a library, cannot go on by itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graincal.campaign.found.next_command import going_on
from graincal.campaign.stored.store import LOOK, holds_campaign
from graincal.data import InputError


@contextmanager
def said_how_to_go_on(folder: Path | None) -> Iterator[None]:
    """Add to an InputError the command that goes on with what is kept in a folder. A first look says nothing of it: its campaign does, which goes on with both."""
    try:
        yield
    except InputError as error:
        if folder is not None and not (folder.name == LOOK and holds_campaign(folder.parent)):
            error.args = (f"{error}\nAll that was finished is stored; when this is mended, go on with:\n  {going_on(folder)}",)
        raise
