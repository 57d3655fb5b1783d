"""graincal resume."""

from __future__ import annotations

from pathlib import Path

from graincal.cli.options import Folder, Quiet, Workers


def resume(folder: Folder, workers: Workers = None, quiet: Quiet = False) -> None:
    """Go on with a campaign that was stopped, to the result that it would have had if it had not been."""
    from graincal import campaign
    from graincal.campaign.store import Store
    from graincal.cli.options import number_of_workers
    from graincal.cli.running import run_and_report

    stop = Store.open(folder).calibration.stop
    chosen = None if workers is None else number_of_workers(workers)
    run_and_report(folder, stop, lambda listeners: campaign.resume(folder, workers=chosen, listeners=listeners), quiet=quiet)
