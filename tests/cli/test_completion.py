"""Shells complete commands, options and folders: each is asked as a person would ask it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

GRAINCAL = Path(sys.executable).with_name("graincal")
TYPED = {
    "graincal cali": "graincal calibrate",
    "graincal calibrate --max": "graincal calibrate --max-evaluations",
    "graincal status camp": "graincal status campaign/",
    "graincal calibrate lab.toml -o camp": "graincal calibrate lab.toml -o campaign/",
}
"""What is typed before the Tab key, and what stands there after it."""


@pytest.fixture
def asked(tmp_path):
    """Runs a shell, where it is installed, in a folder with one campaign, and gives what it prints."""
    (tmp_path / "campaign").mkdir()

    def ask(shell, *arguments):
        if not shutil.which(shell):
            pytest.skip(f"{shell} is not installed")
        if not GRAINCAL.exists():
            pytest.skip("the command graincal is not beside this Python")
        environment = os.environ | {"PATH": f"{GRAINCAL.parent}{os.pathsep}{os.environ['PATH']}", "HOME": str(tmp_path), "TERM": "dumb"}
        ended = subprocess.run([shell, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    return ask


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_names_the_command(call, shell):
    called = call("completion", shell)
    assert called.code == 0 and "_GRAINCAL_COMPLETE=complete_" + shell in called.out and "graincal" in called.out


def test_bash_completes_a_command(asked):
    line = 'eval "$(graincal completion bash)"; COMP_WORDS=(graincal cali); COMP_CWORD=1; _graincal_completion graincal; echo "${COMPREPLY[@]}"'
    assert asked("bash", "-c", line).split() == ["calibrate"]


def test_fish_completes_commands_options_and_folders(asked):
    lines = "\n".join(f"complete -C '{typed}' | string split -f 1 \\t" for typed in TYPED)
    found = asked("fish", "--no-config", "-c", f"graincal completion fish | source\n{lines}\ntrue").split()
    assert found == [line.rpartition(" ")[2] for line in TYPED.values()]


ZSH = """
zmodload zsh/zpty
# Shells in a pseudo terminal of their own, one for each line: a key prints what stands there.
for typed in "$@"; do
  zpty shell zsh -f -i
  zpty -w shell 'PS1= PS2=; eval "$(graincal completion zsh)"; show() { print -r -- "<$BUFFER>" }; zle -N show; bindkey "^X" show; print RE""ADY'
  zpty -r shell said '*READY*'
  zpty -w -n shell "$typed"$'\t\030'
  zpty -r shell said '*<*>*'
  print -r -- "${${said##*<}%%>*}"
  zpty -d shell
done
"""


def test_zsh_completes_commands_options_and_folders_also_where_its_completion_was_off(asked, tmp_path):
    (tmp_path / "ask.zsh").write_text(ZSH)
    found = asked("zsh", "-f", "ask.zsh", *TYPED).splitlines()
    assert [line.strip() for line in found] == list(TYPED.values())
