"""A soil in closed form in place of the engine, for commands that want a built-in test: its strength is its friction, its dilatancy its rolling strength."""

import os

import numpy as np

import graincal as gc
from graincal import demo

from .as_tasks import as_tasks

STRAIN = np.linspace(0, 0.15, 20)


def curves(friction, rolling, at=STRAIN):
    """friction in degrees, rolling from 0 to 1."""
    return {"stress_ratio": 1 + friction / 10 * at, "volumetric_strain": at * (0.1 - rolling)}


def respond(test, samples, at):
    """The outcome of one sample."""
    nothing = np.zeros(len(at))
    ((log_modulus, _, friction, _, rolling),) = test.arrange(samples)
    columns = {**dict.fromkeys(test.returned, nothing), **curves(friction, rolling, at), "void_ratio": 0.7 + nothing}
    columns |= {"mean_stress": nothing + log_modulus, "steps": 1.0 + nothing}
    return gc.Response(at, columns, {"seconds": 0.01, "steps": 100})


tasks = as_tasks(respond)
"""Stands for `StressPathTest.tasks`."""


def packing():
    return gc.Packing.read(f"{os.path.dirname(demo.__file__)}/packing_500.csv")
