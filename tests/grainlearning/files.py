"""Files as GrainLearning writes them."""

import numpy as np


def write_table(path, names, theta, name="soil", iteration=0):
    """A table of samples, for yade-batch: `smcTable0.txt` of older versions, `soil_Iter0_Samples.txt` of newer ones."""
    lines = [" ".join(["!OMP_NUM_THREADS", "description", "key", *names, ""])]
    lines += [
        " ".join([f"{8:2d}", f"{name}_Iter{iteration}_Sample{row:02d}", f"{row:9d}", *(f"{value:20.10e}" for value in values)])
        for row, values in enumerate(theta)
    ]
    path.write_text("\n".join(lines) + "\n")


def write_npy(path, content):
    """A run as a dictionary in a `.npy` file: a pickle."""
    np.save(path, np.array(content, dtype=object), allow_pickle=True)


def write_text(path, content):
    """A dictionary of columns, or of numbers, as text: `_sim.txt` and `_param.txt`."""
    columns = [np.atleast_1d(np.array(values, dtype=object)) for values in content.values()]
    path.write_text("\n".join([f"# {' '.join(content)}", *(" ".join(map(str, row)) for row in zip(*columns))]) + "\n")
