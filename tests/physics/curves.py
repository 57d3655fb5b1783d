"""Curves of triaxial tests, how far apart they are, and replicates of a test run side by side."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np

from graincal import Response, TriaxialTest

OBSERVABLES = ("stress_ratio", "volumetric_strain")
COMPARED = (*OBSERVABLES, "coordination_number", "a_c")


def error(reference, curve, name):
    """Hartmann, Cheng, Thornton (2022), Eq. 5: the error of one quantity over the curve, in percent."""
    return 100 * np.sum(np.abs(reference[name] - curve[name])) / np.sum(np.abs(reference[name]))


def sample_error(reference, curve):
    """Eq. 6 with equal weights: the mean of Eq. 5 over stress ratio and volumetric strain, in percent."""
    return np.mean([error(reference, curve, name) for name in OBSERVABLES])


def mean_curve(curves):
    return {name: np.mean([curve[name] for curve in curves], axis=0) for name in COMPARED}


def replicate_floor(curves):
    """How far apart two honest runs of one test are, in percent: the mean of Eq. 6 over all pairs. A shear of ten percent and more is chaotic."""
    return np.mean([sample_error(one, other) for one, other in permutations(curves, 2)])


def read_columns(path):
    """A curve file, as name -> (T,); its first line is a comment."""
    table = np.genfromtxt(path, delimiter=",", names=True, skip_header=1)
    return {name: table[name] for name in table.dtype.names}


@dataclass(frozen=True)
class YadeCase:
    """A case of the published YADE curves: the test's parameters, and YADE's replicates in the names of graincal's curves."""

    packing: str
    theta: tuple[float, ...]
    confining_pressure: float
    strains: np.ndarray
    replicates: tuple[dict[str, np.ndarray], ...]

    COLUMNS = {"axial_strain": "e_axial", "volumetric_strain": "e_v", "stress_ratio": "s1_over_s3", "coordination_number": "Z", "a_c": "a_c"}

    @classmethod
    def read(cls, files: list[Path]) -> "YadeCase":
        about = json.loads(files[0].read_text().splitlines()[0].removeprefix("#"))
        theta = (np.log10(about["E"]), about["nu"], about["phi"], about["beta_m"], about["eta_m"])
        tables = [read_columns(file) for file in files]
        replicates = tuple({name: table[column] for name, column in cls.COLUMNS.items()} for table in tables)
        strains = about["dstrain"] * np.arange(len(replicates[0]["axial_strain"]))
        return cls(about["packing"], theta, about["conf"], strains, replicates)


class Replicates:
    """Triaxial tests that run on two threads from the moment they are asked for; `values(key)` waits for one of them."""

    def __init__(self):
        self._pool = ThreadPoolExecutor(2)
        self._runs = {}

    def start(self, key, packing, theta, at, confining_pressure, density_scaling, **options):
        test = TriaxialTest(packing, confining_pressure, density_scaling=density_scaling, **options)
        self._runs[key] = self._pool.submit(lambda: test.simulate([theta], at=at, threads=1)[0])

    def values(self, key):
        response = self._runs[key].result()
        assert isinstance(response, Response), response
        assert response.details["flagged"] == 0
        return response.values

    def stop(self):
        self._pool.shutdown(cancel_futures=True)
