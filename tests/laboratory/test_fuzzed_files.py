"""Laboratory and packing files with mistakes in them: each is read, asked about, or refused in a sentence."""

import random
from pathlib import Path

import numpy as np
import pytest
from fuzzing import SEEDS, fuzzed, mutated, refused_in_words
from hypothesis import given

from graincal.campaign.file.propose import propose, propose_unknown
from graincal.data import Reference
from graincal.dem.packing import Packing
from graincal.laboratory import understand
from graincal.laboratory.describe import describe
from graincal.laboratory.table import read_table
from graincal.laboratory.understanding.case import NotUnderstood

STRAIN = np.array([0, 0.1, 0.5, 1, 2, 4, 8, 15])
STRESS = 300 * STRAIN / (0.6 + STRAIN)


def table(delimiter: str, decimal: str, *columns: tuple[str, object], head: str = "") -> str:
    rows = zip(*(values for _, values in columns))
    lines = [head, delimiter.join(name for name, _ in columns), *(delimiter.join(f"{value:.4f}".replace(".", decimal) for value in row) for row in rows)]
    return "\n".join(line for line in lines if line) + "\n"


DRAINED = ("Axial strain [%]", STRAIN), ("Deviator stress [kPa]", STRESS), ("Volumetric strain [%]", 0.3 * STRAIN - 0.05 * STRAIN**2)
FILES = [
    table(",", ".", *DRAINED, head="Drained triaxial test, confining pressure: 100 kPa\nSample height,100,mm"),
    table(";", ",", *DRAINED, head="# Zelldruck [kPa]; 100"),
    table("\t", ".", *DRAINED),
    table(",", ".", ("Vertical stress (kPa)", [12.5, 25, 50, 100, 200]), ("Void ratio", [0.72, 0.71, 0.70, 0.68, 0.66]), head="Oedometer test"),
    table(",", ".", ("axial_strain", STRAIN / 100), ("stress_ratio", 1 + STRESS / 100), ("volumetric_strain", STRAIN / 500)),
    '"GROUP","TRIX"\n"HEADING","LOCA_ID","TRIX_STRN","TRIX_DEVS"\n"UNIT","","%","kPa"\n"TYPE","ID","2DP","1DP"\n"DATA","BH1","0.0","0"\n"DATA","BH1","1.0","50"\n"DATA","BH1","2.0","80"\n',
]
GRID = 2e-3 * np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
PACKING = "\n".join(["# simple cubic; cell lengths: 6e-3 6e-3 6e-3", "x,y,z,radius", *(f"{x},{y},{z},1.0001e-3" for x, y, z in GRID[:12])]) + "\n"
OPTIONS = [
    {},
    {"strain": "engineering", "confining_pressure": 1e5},
    {"columns": {"axial_strain": 1, "stress_ratio": 2}, "observables": ("stress_ratio",)},
    {"until": 0.1},
    {"rows": (2, 8)},
    {"unloading": "drop", "compression": "negative"},
]


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fuzzed") / "mutated.csv"


@pytest.mark.slow
@fuzzed
@given(seed=SEEDS)
def test_a_laboratory_file_with_mistakes_is_read_or_refused_in_a_sentence(file: Path, seed: int) -> None:
    rng = random.Random(seed)
    encoding = rng.choice(["utf-8", "utf-8", "utf-16", "cp1252"])
    file.write_bytes(mutated(rng.choice(FILES), seed).encode(encoding, errors="ignore"))

    def as_init_does() -> None:
        try:
            found = understand(file)
        except NotUnderstood:
            propose_unknown(read_table(file))
            raise
        describe(found)
        propose(found)

    refused_in_words(as_init_does)
    refused_in_words(lambda: Reference.read(file, **rng.choice(OPTIONS)))


@pytest.mark.slow
@fuzzed
@given(seed=SEEDS)
def test_a_packing_file_with_mistakes_is_read_or_refused_in_a_sentence(file: Path, seed: int) -> None:
    file.write_bytes(mutated(PACKING, seed).encode("utf-8", errors="ignore"))
    refused_in_words(lambda: Packing.read(file))
