"""What is said where a campaign waits for runs that are made by hand."""

from __future__ import annotations

import shlex
from pathlib import Path

from graincal.campaign.asked.calibration import Calibration, round_of
from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.by_hand import by_hand
from graincal.campaign.run.told_files import FAILED, ending
from graincal.campaign.stored.store import Store


class RunsWait(Exception):
    """A campaign cannot go on before somebody has made runs by hand and told what they gave. The message says which runs, and what to do."""

    @classmethod
    def of(cls, store: Store, calibration: Calibration, iteration: int, count: int) -> RunsWait:
        """So many runs of an iteration."""
        which = f"{round_of(calibration.method).capitalize()} {iteration}: {count} run{'s wait' if count > 1 else ' waits'} to be made by hand."
        return cls(which if store.folder is None else f"{which}\n{what_to_do(store.folder, calibration)}")


def what_to_do(folder: Path, calibration: Calibration) -> str:
    """The commands to type, and the names of the files that are expected."""
    names = [file_name(calibration.experiments[number].name) for number in by_hand(calibration)]
    endings = " or ".join(dict.fromkeys(f"<id>{ending(calibration.experiments[number])}" for number in by_hand(calibration)))
    within = "" if len(calibration.experiments) == 1 else f", in a folder for each experiment ({', '.join(names)})"
    quoted = shlex.quote(str(folder))
    return (
        f"Their ids and parameters are printed by:\n  graincal ask {quoted}\n"
        f"Store the curve of each run as {endings}{within}; where a run gives none, write the reason into <id>{FAILED}. Some at a time will do. Then:\n"
        f"  graincal tell {quoted} FOLDER"
    )
