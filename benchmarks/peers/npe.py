"""Neural posterior estimation by sbi (Tejero-Cantero et al. 2020, JOSS 5), `pip install sbi`: sequential, in rounds of 100 simulations (Greenberg, Nonnenmacher,
Macke 2019).

Its defaults, but for rounds. What it learns from are curves with errors as the reference has them, of which the network sees all values.
"""

import logging
import os
import tempfile
import warnings

import numpy as np
import torch
from sbi.inference import NPE
from sbi.utils import BoxUniform

ROUND = 100
SAMPLES = 4000


def calibrate(task, seed):
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    # It writes logs where it runs.
    os.chdir(tempfile.mkdtemp(prefix="graincal-sbi-"))
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    rng = np.random.default_rng(seed)
    prior = BoxUniform(low=torch.zeros(len(task.names)), high=torch.ones(len(task.names)))
    observed = torch.tensor((task.observed / task.deviations).ravel(), dtype=torch.float32)
    inference, proposal = NPE(prior, show_progress_bars=False), prior
    while True:
        unit = proposal.sample((ROUND,), show_progress_bars=False) if proposal is not prior else prior.sample((ROUND,))
        curves = task.evaluate(task.low + unit.numpy() * (task.high - task.low)) / task.deviations
        curves = curves + rng.standard_normal(curves.shape)
        seen = torch.tensor(curves.reshape(ROUND, -1), dtype=torch.float32)
        inference.append_simulations(unit, seen, proposal=proposal).train(show_train_summary=False)
        proposal = inference.build_posterior().set_default_x(observed)
        samples = task.low + proposal.sample((SAMPLES,), show_progress_bars=False).numpy() * (task.high - task.low)
        task.posterior(samples.mean(axis=0), samples.std(axis=0))
