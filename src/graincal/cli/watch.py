"""graincal watch."""

from __future__ import annotations

from typing import Annotated

import typer

from graincal.cli.options import Folder
from graincal.cli.saying import say


def watch(
    folder: Folder,
    host: Annotated[
        str, typer.Option(help="The address to listen at. Another than this machine's own lets others in, and nothing is encrypted.", metavar="ADDRESS")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="The port; 0 for any that is free.", min=0, max=65535)] = 0,
) -> None:
    """Serve a page that follows a campaign while it runs, here or elsewhere: its figures, its evaluations and what they printed. It reads, and changes nothing."""
    from graincal.campaign.stored.store import Store
    from graincal.data import InputError
    from graincal.watching.access import LOOPBACK
    from graincal.watching.server import Server

    Store.open(folder)
    try:
        server = Server(folder, host, port)
    except (OSError, OverflowError, UnicodeError) as error:
        raise InputError(
            f"--host {host} --port {port}: no page can be served there ({error}), and an address of this machine and a free port were expected."
        ) from None
    if host not in LOOPBACK:
        say(
            f"Warning: the page is served at {host}, and nothing is encrypted: whoever sees the network's traffic can read it, and the link too. `ssh -L` is the safe way.",
            err=True,
        )
    say(f"Open this link; Ctrl-C ends the page, and the campaign goes on.\n{server.link}")
    with server:
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            say("The page has ended.", err=True)
