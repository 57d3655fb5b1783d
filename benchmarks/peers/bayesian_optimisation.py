"""Bayesian optimisation of the error, `pip install scikit-learn`: a Gaussian process on its logarithm, expected improvement; one evaluation at a time."""

import warnings

import numpy as np
from scipy.optimize import minimize
from scipy.stats import norm, qmc
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel


def calibrate(task, seed):
    warnings.simplefilter("ignore")
    rng = np.random.default_rng(seed)
    size = len(task.names)
    unit = qmc.Sobol(d=size, seed=rng).random(16)
    values = np.log(task.error(task.evaluate(task.low + unit * (task.high - task.low))))
    kernel = ConstantKernel(1.0) * Matern(np.ones(size), (5e-2, 20), nu=2.5) + WhiteKernel(1e-4, (1e-8, 1e-1))
    while True:
        # Hyperparameters hardly change from one evaluation to the next; a search for them at each would take most of the time.
        search = len(values) < 60 or len(values) % 10 == 0
        process = GaussianProcessRegressor(kernel, normalize_y=True, optimizer="fmin_l_bfgs_b" if search else None).fit(unit, values)
        kernel = process.kernel_
        point = _most_expected_improvement(process, values.min(), unit[np.argmin(values)], rng)
        unit = np.vstack([unit, point])
        values = np.append(values, np.log(task.error(task.evaluate(task.low + point * (task.high - task.low)))))


def _most_expected_improvement(process, best, incumbent, rng):
    def improvement(points):
        mean, deviation = process.predict(np.atleast_2d(points), return_std=True)
        deviation = np.maximum(deviation, 1e-9)
        z = (best - mean) / deviation
        return deviation * (z * norm.cdf(z) + norm.pdf(z))

    near = np.clip(incumbent + 0.05 * rng.standard_normal((500, len(incumbent))), 0, 1)
    candidates = np.vstack([rng.random((2000, len(incumbent))), near])
    expected = improvement(candidates)
    starts = candidates[np.argsort(expected)[-3:]]
    found = [minimize(lambda x: -np.log(improvement(x)[0] + 1e-300), start, bounds=[(0, 1)] * len(start), options={"maxiter": 20}) for start in starts]
    return np.clip(min(found, key=lambda each: each.fun).x, 0, 1)
