"""Models in closed form that stand in for simulations, and the loop that drives a filter with one."""

import numpy as np

from graincal.data import ParameterSpace, Reference

STRAIN = np.linspace(0, 0.2, 51)
CENTRED = 10 * STRAIN - 1

LINE_SPACE = ParameterSpace({"slope": (0, 4), "offset": (-1, 1)})

SHEAR_SPACE = ParameterSpace({"strength": (1, 6), "half_strain": (0.001, 0.05), "contraction": (0, 1), "dilation": (0, 10)})
SHEAR_TRUTH = np.array([3.2, 0.012, 0.35, 4.0])


def line(theta):
    """A straight line about the middle of the strain, so that its two parameters do not trade: (T, 1)."""
    slope, offset = theta
    return (offset + slope * CENTRED)[:, None]


def shear(theta):
    """A hyperbolic stress ratio and a volumetric strain that contracts, then dilates through zero: (T, 2)."""
    strength, half_strain, contraction, dilation = theta
    stress_ratio = 1 + strength * STRAIN / (half_strain + STRAIN)
    return np.stack([stress_ratio, contraction * STRAIN - dilation * STRAIN**2], axis=1)


def reference_of(values, names=("stress_ratio", "volumetric_strain"), shares=None):
    """A reference with these values (T, J)."""
    names = names[: values.shape[1]]
    shares = None if shares is None else dict(zip(names, shares))
    control = STRAIN if len(values) == len(STRAIN) else np.arange(len(values))
    return Reference(control, dict(zip(names, values.T)), variance_shares=shares)


def responses_of(model, samples):
    """What the model returns for each of the samples, (N, T, J)."""
    return np.array([model(theta) for theta in samples.theta])


def run(filter, model):
    """Drive a filter to its end, and return it."""
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, responses_of(model, samples))
    return filter
