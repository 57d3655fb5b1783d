"""The demo by several seeds: whether it settles by itself, how long it takes, and how often its intervals hold the truth.

    python benchmarks/demo.py [--seeds 1 2 ... 10] [--instruction-set x86-64-v2] [--folder DIR]

Each seed is the calibration of `graincal demo` in DIR/SEED, gone on with where it was broken off: five unknowns over the paper's ranges, on the demo's packing, against a run at known parameters on a
sibling of it. The seed changes where the ranges are sampled; the reference stays. Printed are evaluations, wall time from the first to the last of them, and the parameters whose intervals of 50 and
90 % hold the truth. With --instruction-set the engine runs as on an older processor: its runs differ in the last digits, and so after some strain in all of them.
"""

from __future__ import annotations

import argparse
from datetime import datetime
from functools import partial
from pathlib import Path

import numpy as np

from graincal import _native, demo
from graincal.campaign import begin, resume
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import holds_campaign

LEVELS = (0.5, 0.9)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", nargs="+", type=int, default=list(range(1, 11)))
    parser.add_argument("--instruction-set", choices=("x86-64-v2", "x86-64-v3", "x86-64-v4"))
    parser.add_argument("--folder", type=Path, default=Path("demos"))
    arguments = parser.parse_args()
    if arguments.instruction_set:
        _native.Batch = partial(_native.Batch, instruction_set=arguments.instruction_set)
    grains, reference = demo.packing(), demo.reference(demo.sibling())
    truth, settled, inside = np.array(list(demo.TRUTH.values())), 0, np.zeros(len(LEVELS), dtype=int)
    for seed in arguments.seeds:
        folder = arguments.folder / str(seed)
        result = resume(folder) if folder.exists() and holds_campaign(folder) else begin(demo.calibration(grains, reference, seed=seed), folder)
        said = status(folder)
        started, ended = (datetime.fromisoformat(said[key]) for key in ("started", "updated"))
        held = np.array([np.sum((low <= truth) & (truth <= high)) for low, high in map(result.posterior.interval, LEVELS)])
        settled, inside = settled + said["settled"], inside + held
        words = f"{(ended - started).total_seconds():.0f} s; " + ", ".join(f"{count} of {len(truth)} in {level:.0%}" for count, level in zip(held, LEVELS))
        print(
            f"seed {seed}: {'settled' if said['settled'] else 'not settled'} after {result.evaluations} evaluations, {words}; ε of the answer {result.answer.mean:.2f} %",
            flush=True,
        )
    total = len(arguments.seeds) * len(truth)
    print(
        f"{settled} of {len(arguments.seeds)} settled; "
        + ", ".join(f"{count} of {total} intervals of {level:.0%} hold the truth" for count, level in zip(inside, LEVELS))
    )


if __name__ == "__main__":
    main()
