"""Shells complete commands and options."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

GRAINCAL = Path(sys.executable).with_name("graincal")


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_the_script_names_the_command(call, shell):
    called = call("completion", shell)
    assert called.code == 0 and "_GRAINCAL_COMPLETE=complete_" + shell in called.out and "graincal" in called.out


def test_bash_completes_a_command():
    if not shutil.which("bash"):
        pytest.skip("bash is not installed")
    if not GRAINCAL.exists():
        pytest.skip("the command graincal is not beside this Python")
    asked = 'eval "$(graincal completion bash)"; COMP_WORDS=(graincal cali); COMP_CWORD=1; _graincal_completion graincal; echo "${COMPREPLY[@]}"'
    path = f"{GRAINCAL.parent}{os.pathsep}{os.environ['PATH']}"
    ended = subprocess.run(["bash", "-c", asked], env=os.environ | {"PATH": path}, capture_output=True, text=True, timeout=120)
    assert ended.stdout.split() == ["calibrate"], ended.stderr
