"""graincal completion: commands and options completed by a shell, as Typer does it."""

from __future__ import annotations

import os
from enum import Enum
from typing import Annotated

import typer

ASKED_BY = "_GRAINCAL_COMPLETE"
"""The variable by which a shell's script asks for what may follow."""


class Shell(str, Enum):
    """The shells that are known."""

    bash = "bash"
    zsh = "zsh"
    fish = "fish"


_BEFORE = {Shell.zsh: "(( $+functions[compdef] )) || { autoload -Uz compinit && compinit }\n"}
"""What a shell needs first: zsh's completion is off until its start file calls for it."""


def completion(shell: Annotated[Shell, typer.Argument(help="The shell.", metavar="bash|zsh|fish")]) -> None:
    """Print the script by which a shell completes commands, options and files.

    In its start file: eval "$(graincal completion bash)", the same with zsh, or graincal completion fish | source.
    """
    from typer.completion import get_completion_script

    typer.echo(_BEFORE.get(shell, "") + get_completion_script(prog_name="graincal", complete_var=ASKED_BY, shell=shell.value))


def ready_to_complete() -> None:
    """Have the shell's question answered, where this process is one."""
    if ASKED_BY in os.environ:
        from typer.completion import completion_init

        completion_init()
