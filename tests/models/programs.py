"""Programs for tests, which behave and misbehave; and what is left of them."""

import os
import sys
import time
from pathlib import Path

import numpy as np

from graincal import Samples
from graincal.models import CommandModel
from graincal.models.command.folders import Folders
from graincal.models.command.work import Limits
from graincal.models.output import Column, Output

AT = np.array([0.01, 0.05, 0.1])
PYTHON = (sys.executable, "-I", "-S", "-c")

WRITES = """
import sys
a = float(sys.argv[1])
with open("curve.csv", "w") as file:
    file.write("eps_a [%],ratio\\n")
    for k in range(13):
        file.write(f"{k!r},{1 + a * k / 100!r}\\n")
"""
"""Writes a curve of the slope that is its first argument."""

OUTPUT = Output({"axial_strain": Column("eps_a [%]"), "stress_ratio": Column("ratio")}, "curve.csv")


def model(program=WRITES, *arguments, command=None, output=OUTPUT, root=None, keep="failed", scratch=None, limits=None, **options):
    """A Python program, or a command."""
    limits = Limits(**{"time_limit": 60.0} | (limits or {}))
    return CommandModel(command or (*PYTHON, program, *(arguments or ("{{ a }}",))), output, limits=limits, folders=Folders(root, keep, scratch), **options)


def shell(script, **options):
    return model(command=("sh", "-c", script, "sh", "{{ a }}"), **options)


def samples(*thetas, names=("a",)):
    theta = np.array(thetas, dtype=float).reshape(-1, len(names))
    return Samples(np.arange(len(theta)), theta, names)


def outcomes(model, *thetas, workers=2, names=("a",)):
    found = dict(model.evaluate(samples(*thetas, names=names), at=AT, workers=workers))
    return [found[row] for row in range(len(found))]


def outcome(model, a=2.0, **options):
    return outcomes(model, a, **options)[0]


def running(mark):
    """The processes whose command line holds a mark, but for zombies; a test makes a mark that nobody else has."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if mark.encode() in (folder / "cmdline").read_bytes() and int(folder.name) != os.getpid():
                found.append(int(folder.name))
        except OSError:
            continue
    return found


def ends(mark, within=10.0):
    """Whether all processes with a mark end within some seconds."""
    until = time.monotonic() + within
    while running(mark):
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True
