"""A command in a pseudo-terminal, and a person who answers there."""

import os
import pty
import subprocess
import sys

END_OF_INPUT = "\x04"


def in_terminal(arguments, answers=(), environment=None):
    """The exit code of a command, and what it prints to the terminal with what is typed there: one answer at each prompt, and then the end of input."""
    ours, theirs = pty.openpty()
    kept = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR", "CI")} | {"TERM": "dumb"}
    command = [sys.executable, "-c", "import sys; from graincal.cli import main; main(sys.argv[1:])", *map(str, arguments)]
    ran = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=kept | (environment or {}))
    os.close(theirs)
    read, waiting = b"", [*(f"{answer}\n" for answer in answers), END_OF_INPUT]
    # Its end is an error of reading, on Linux.
    try:
        while piece := os.read(ours, 65536):
            read += piece
            if waiting and read.endswith(b"): "):
                os.write(ours, waiting.pop(0).encode())
    except OSError:
        pass
    os.close(ours)
    return ran.wait(timeout=60), read.decode().replace("\r\n", "\n")
