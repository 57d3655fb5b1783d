"""Begins the campaigns of this folder and breaks them off, and writes what they come to when nothing stops them: `python tests/data/begun/make.py`, by the version whose campaigns later ones are to go on with.

`engine`: the paper's method on the built-in test. `function`: the posterior of a function, with batches that overlap.
"""

import json
import multiprocessing
import os
import shutil
import sys
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.campaign import begin
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.provenance import provenance

HERE = Path(__file__).parent
STRAINS = np.linspace(0.002, 0.02, 10)
SPACE = gc.ParameterSpace({"log_E": (8, 9), "phi": (15, 45)}, {"log_E": "log10 Pa", "phi": "deg"})
CURVE = gc.ParameterSpace({"strength": (0.5, 6), "strain": (0.001, 0.05), "dilatancy": (0, 0.6)})


def respond(theta):
    strength, strain, dilatancy = theta
    return {"stress_ratio": 1 + strength * STRAINS / (strain + STRAINS), "volumetric_strain": -dilatancy * STRAINS**2 / (strain + STRAINS)}


def engine():
    from graincal.dem.preparation import prepare

    test = gc.TriaxialTest(prepare(200, 0.68, seed=1), 0.5e6, fixed={"nu": 0.2, "beta_m": 0.1, "eta_m": 0.3})
    (run,) = test.simulate([[8.4, 30.0]], at=STRAINS)
    reference = gc.Reference(STRAINS, {name: run.values[name] for name in ("stress_ratio", "volumetric_strain")}, simulated=True)
    return gc.campaign.Calibration(
        SPACE,
        [gc.Experiment("0.5 MPa", test, reference)],
        "iterative-bayesian",
        {"alpha": 12},
        gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=3),
        3,
        2,
    )


def function():
    at = respond((3.0, 0.01, 0.3))
    reference = gc.Reference(STRAINS, at, measurement_errors={"stress_ratio": 0.05, "volumetric_strain": 0.0003})
    stop = gc.Stop(max_evaluations=30)
    return gc.campaign.Calibration(
        CURVE, [gc.Experiment("curve", gc.PythonModel(respond), reference)], "posterior", {"first_batch": 12, "batch": 6, "ahead": 1}, stop, 3, 2
    )


CAMPAIGNS = {"engine": (engine, 25), "function": (function, 16)}


class Ends(Listener):
    """Ends the process once so many evaluations are stored."""

    def __init__(self, after):
        self.left = after

    def evaluated(self, sample, experiment, outcome):
        self.left -= 1
        if not self.left:
            os._exit(9)


def answer(result):
    """What is compared, bit for bit: all samples and errors, and the weights of the last iteration or of the posterior."""
    return {"ids": result.ids, "samples": result.samples, "errors": result.errors, "posterior": result.posterior.samples, "weights": result.posterior.weights}


def begin_one(name):
    make, after = CAMPAIGNS[name]
    begin(make(), HERE / name, [Ends(after)])


def main():
    for name, (make, _) in CAMPAIGNS.items():
        shutil.rmtree(HERE / name, ignore_errors=True)
        process = multiprocessing.get_context("fork").Process(target=begin_one, args=(name,))
        process.start()
        process.join()
        for path in (HERE / name).iterdir():
            if path.name != "campaign.db":
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        np.savez_compressed(HERE / f"{name}.npz", **answer(begin(make())))
    (HERE / "made-with.json").write_text(json.dumps(provenance(), indent=1))


if __name__ == "__main__":
    sys.exit(main())
