"""CMA-ES (Hansen 2001) on the error, `pip install cma`: a third of the box at first, restarts with twice the population, as its authors advise."""

import cma


def calibrate(task, seed):
    # The options of `cma.fmin2` and nothing else: sigma of 0.3 in a unit cube, and restarts until there are no evaluations left.
    def error(unit):
        return float(task.error(task.evaluate(task.low + unit * (task.high - task.low)))[0])

    cma.fmin2(error, [0.5] * len(task.names), 0.3, {"bounds": [0, 1], "seed": seed + 1, "verbose": -9}, restarts=9, bipop=True)
