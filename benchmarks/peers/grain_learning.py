"""GrainLearning 2.0.5 (Cheng et al. 2024, JOSS 9), `pip install grainlearning==2.0.5`, iterated until there are no evaluations left.

settings=defaults: the tool's own, but for the number of samples, which has none and is the paper's 10 n ln n. settings=best: see `BEST`.
"""

import numpy as np
from grainlearning import BayesianCalibration

# What had the least medians, of 20, 40 or 80 samples, a target of 0.1 or 0.3, 1 or 8 components that share a covariance or do not.
BEST = {
    "num_samples": 20,
    "Bayes_filter": {"ess_target": 0.3, "scale_cov_with_max": True},
    "sampling": {"max_num_components": 1, "covariance_type": "tied"},
}


def calibrate(task, seed, settings, **changed):
    best = settings == "best"
    if best:
        chosen = {key: value if isinstance(value, int) else dict(value) for key, value in BEST.items()}
    else:
        count = len(task.names)
        chosen = {"num_samples": round(10 * count * np.log(count)), "Bayes_filter": {}, "sampling": {"max_num_components": 1}}

    def model(calibration):
        curves = task.evaluate(calibration.system.param_data)
        calibration.system.set_sim_data(np.swapaxes(curves, 1, 2))

    calibration = BayesianCalibration.from_dict(
        {
            "num_iter": 1,
            "callback": model,
            "system": {
                "param_names": task.names,
                "param_min": task.low.tolist(),
                "param_max": task.high.tolist(),
                "num_samples": chosen["num_samples"],
                "obs_data": task.observed.T,
                "ctrl_data": task.control,
                "obs_names": task.observables,
            },
            "inference": {"Bayes_filter": chosen["Bayes_filter"], "sampling": chosen["sampling"] | {"random_state": seed}},
            "save_fig": -1,
        }
    )
    while True:
        try:
            calibration.run_one_iteration()
        except (ValueError, FloatingPointError) as gone:
            # All its weights are 0/0, or all are one sample's: it has nothing left to draw from.
            print(f"GrainLearning ends: {gone}")
            return
        mean = calibration.system.estimated_params[-1]
        task.posterior(mean, np.abs(mean * calibration.system.estimated_params_cv[-1]))
