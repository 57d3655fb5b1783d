"""pyABC (Klinger, Rickert, Hasenauer 2018), `pip install pyabc`: sequential Monte Carlo, populations of 50.

Where the reference has errors, its exact likelihood by a stochastic acceptor and temperatures (Schälte, Hasenauer 2020); the error as a distance
otherwise.
"""

import logging
import random

import numpy as np
import pyabc

POPULATION = 50


def calibrate(task, seed):
    logging.getLogger("ABC").setLevel(logging.ERROR)
    np.random.seed(seed)
    random.seed(seed)
    said = -1

    def model(parameters):
        nonlocal said
        if task.deviations is not None and abc.history.n_populations - 1 > said:
            said = abc.history.n_populations - 1
            frame, weights = abc.history.get_distribution(t=said)
            samples = frame[task.names].to_numpy()
            mean = weights @ samples
            task.posterior(mean, np.sqrt(weights @ (samples - mean) ** 2))
        return {"curves": task.evaluate(np.array([parameters[name] for name in task.names]))[0].ravel()}

    prior = pyabc.Distribution(**{name: pyabc.RV("uniform", low, high - low) for name, low, high in zip(task.names, task.low, task.high)})
    options = {"population_size": POPULATION, "sampler": pyabc.SingleCoreSampler()}
    if task.deviations is None:
        shape = task.observed.shape

        def distance(found, known):
            return float(task.error(found["curves"].reshape(1, *shape))[0])

        abc = pyabc.ABCSMC(model, prior, distance, **options)
    else:
        variances = np.tile(task.deviations**2, len(task.control))
        kernel = pyabc.IndependentNormalKernel(var=variances)
        abc = pyabc.ABCSMC(model, prior, kernel, eps=pyabc.Temperature(), acceptor=pyabc.StochasticAcceptor(), **options)
    abc.new("sqlite://", {"curves": task.observed.ravel()})
    abc.run()
