"""PyVBMC (Huggins, Li, Tobaben, Aarnos, Acerbi 2023, JOSS 8), `pip install pyvbmc`: variational Bayesian Monte Carlo on the exact log posterior.

Defaults, but for the number of evaluations and for a rule of stopping: it goes on until there are no evaluations left. Hard bounds are those of the prior;
plausible ones hold its inner 80 %. It starts at the middle.
"""

import warnings

import numpy as np
from pyvbmc import VBMC

MOST = 600
SAMPLES = 20_000
"""That a variational posterior's moments are from, where its parameters are transformed."""


def calibrate(task, seed):
    warnings.simplefilter("ignore")
    np.random.seed(seed)
    width = task.high - task.low
    said = 0

    def log_joint(theta):
        nonlocal said
        if len(found := posteriors()) > said:
            said = len(found)
            samples, _ = found[-1].sample(SAMPLES)
            task.posterior(samples.mean(axis=0), samples.std(axis=0))
        residuals = (task.evaluate(theta)[0] - task.observed) / task.deviations
        return float(-0.5 * np.sum(residuals**2) - np.sum(np.log(width)))

    def posteriors():
        kept = None if vbmc is None else vbmc.iteration_history["vp"]
        return [] if kept is None else list(kept)

    vbmc = None
    options = {"max_fun_evals": MOST, "max_iter": 10 * MOST, "tol_stable_count": 10 * MOST, "display": "off"}
    vbmc = VBMC(log_joint, (task.low + 0.5 * width)[None], task.low, task.high, task.low + 0.1 * width, task.high - 0.1 * width, options=options)
    vbmc.optimize()
