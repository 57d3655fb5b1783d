"""What a look at the evaluations found, as bytes for the store: NumPy's .npz format, with every bit; nothing in it is executed."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.emulator.emulator import Kernels
from graincal.inference.emulator.process import Kernel
from graincal.inference.posterior.doubt import Doubt
from graincal.inference.posterior.emulation import Found
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.explore import Explored
from graincal.inference.sampling.proposal import TruncatedMixture

_EXPLORED = ("theta", "log_weights", "log_likelihood", "log_evidence", "log_evidence_std", "tempered")
_MIXTURE = ("weights", "means", "covariances")
_DOUBT = ("means", "spreads", "log_evidence")
_FIGURES = ("answer", "coverage", "weights", "pareto_k", "log_evidence_of_runs", "dropped", "lost")
_SEVERAL = ("held_out", "of_mean", "spread")
"""Those with a number for each experiment."""

Arrays = Mapping[str, NDArray]


def pack_look(found: Found) -> bytes:
    """What was found, as bytes."""
    proposal = found.explored.proposal
    arrays = _named(found, (*_FIGURES, *_SEVERAL), "") | _named(found.explored, _EXPLORED, "explored.") | _named(found.doubt, _DOUBT, "doubt.")
    arrays["proposal.prior_share"] = np.asarray(proposal.prior_share)
    if proposal.mixture is not None:
        arrays |= _named(proposal.mixture, _MIXTURE, "proposal.")
    arrays |= _packed(found.kernels, "kernels") | _packed(found.cheaper, "cheaper")
    arrays["impossible"] = _rows(found.of_impossible)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]  # no array has the name of an option
    return buffer.getvalue()


def unpack_look(blob: bytes, space: ParameterSpace) -> Found:
    """What `pack_look` made bytes of, of parameters in this space."""
    with np.load(io.BytesIO(blob), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    mixture = TruncatedMixture(space, **_read(arrays, _MIXTURE, "proposal.")) if "proposal.weights" in arrays else None
    proposal = DefensiveMixture(space, mixture, float(arrays["proposal.prior_share"]))
    figures = _read(arrays, _FIGURES, "")
    # Versions before looked at fewer of them.
    figures |= {name: tuple(map(float, arrays.get(name, ()))) for name in _SEVERAL}
    return Found(
        explored=Explored(proposal=proposal, **_read(arrays, _EXPLORED, "explored.")),
        doubt=Doubt(**_read(arrays, _DOUBT, "doubt.")),
        kernels=_unpacked(arrays, "kernels"),
        cheaper=_unpacked(arrays, "cheaper"),
        of_impossible=_kernels(arrays["impossible"]),
        **figures,
    )


def _named(holder: object, names: Sequence[str], prefix: str) -> dict[str, NDArray]:
    return {prefix + name: np.asarray(getattr(holder, name)) for name in names}


def _read(arrays: Arrays, names: Sequence[str], prefix: str) -> dict[str, Any]:
    """The arrays of these names, and plain numbers for those that are one."""
    return {name: array if array.ndim else array.item() for name in names for array in [arrays[prefix + name]]}


def _packed(every: Sequence[Kernels], name: str) -> dict[str, NDArray]:
    """The powers of each emulator, and its kernels."""
    return {f"{name}.{number}.{what}": array for number, each in enumerate(every) for what, array in (("powers", each.powers), ("rows", _rows(each.kernels)))}


def _unpacked(arrays: Arrays, name: str) -> tuple[Kernels, ...]:
    count = sum(key.startswith(f"{name}.") and key.endswith(".powers") for key in arrays)
    return tuple(Kernels(arrays[f"{name}.{number}.powers"], _kernels(arrays[f"{name}.{number}.rows"])) for number in range(count))


def _rows(kernels: Sequence[Kernel]) -> NDArray[np.float64]:
    """A row for each: variance, lengths and nugget."""
    return np.array([[kernel.variance, *kernel.lengths, kernel.nugget] for kernel in kernels])


def _kernels(rows: NDArray[np.float64]) -> tuple[Kernel, ...]:
    return tuple(Kernel(float(row[0]), row[1:-1], float(row[-1])) for row in rows)
