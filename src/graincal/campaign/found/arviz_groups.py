"""A result as ArviZ reads it: the groups of its schema."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.found.emulated import DRAWN
from graincal.data import InputError, Response
from graincal.errors import not_installed
from graincal.inference.sampling.proposal import systematic_resampling
from graincal.inference.sampling.samples import halton

if TYPE_CHECKING:
    from graincal.campaign.found.emulated import Emulated
    from graincal.campaign.found.record import Record
    from graincal.inference import Iteration

Group = dict[str, NDArray[np.float64]]


@dataclass
class Groups:
    """Arrays by group and name; posterior, prior, sample_stats and posterior_predictive begin with a chain, of which there is one, and DRAWN draws of equal weight. dims: names of the axes behind these, whose values are in coords."""

    posterior: Group = field(default_factory=dict)
    sample_stats: Group = field(default_factory=dict)
    prior: Group = field(default_factory=dict)
    posterior_predictive: Group = field(default_factory=dict)
    observed_data: Group = field(default_factory=dict)
    coords: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    dims: dict[str, list[str]] = field(default_factory=dict)

    @property
    def data(self) -> dict[str, Group]:
        """The groups that hold something."""
        named = {name: getattr(self, name) for name in ("posterior", "sample_stats", "prior", "posterior_predictive", "observed_data")}
        return {name: group for name, group in named.items() if group}


def groups(result: Record, emulated: Emulated | None) -> Groups:
    """The groups of a result that has a posterior: of an emulated one with measurements that it predicts, of another with the responses of its samples.

    Raises InputError where there is no posterior.
    """
    if result.posterior is None:
        raise InputError("to_arviz needs a posterior, and the campaign has none yet.")
    found = Groups()
    if emulated:
        rows, curves = emulated.drawn, [(each.control, each.measurement) for each in emulated.predictive]
        observed = [reference.values for reference in result.knowledge.kept]
        logs = emulated.emulation.explored.log_likelihood[rows]
        found.sample_stats = {"lp": logs[None]}
    else:
        rows = systematic_resampling(result.posterior.weights, DRAWN, np.random.default_rng(0))
        curves = [(experiment.reference.control, _responses(result, number, rows)) for number, experiment in enumerate(result.experiments)]
        observed = [experiment.reference.values for experiment in result.experiments]
        errors = _last_weighted(result).errors[rows]
        found.sample_stats = {"error": errors[None]}
    found.posterior = _by_name(result, result.posterior.samples[rows])
    found.prior = _by_name(result, halton(result.space, DRAWN, np.random.default_rng(0)))
    for experiment, (control, predicted), measured in zip(result.experiments, curves, observed):
        before = f"{experiment.name}: " if len(result.experiments) > 1 else ""
        along = f"{before}{experiment.reference.control_name}"
        found.coords[along] = control
        for place, name in enumerate(experiment.reference.names):
            found.posterior_predictive[f"{before}{name}"] = predicted[None, :, :, place]
            found.observed_data[f"{before}{name}"] = measured[:, place]
            found.dims[f"{before}{name}"] = [along]
    return found


def to_arviz(result: Record, emulated: Emulated | None) -> Any:
    """The groups as the installed ArviZ has them: an xarray.DataTree from its version 1 on, an InferenceData before. Parameters have their range and unit as attributes.

    Raises InputError where ArviZ is not installed, and where there is no posterior.
    """
    try:
        import arviz as az
    except ImportError as error:
        raise not_installed("to_arviz", "ArviZ", "notebook", error) from None
    found = groups(result, emulated)
    held = {"coords": found.coords, "dims": found.dims}
    tree = az.from_dict(**found.data, **held) if hasattr(az, "InferenceData") else az.from_dict(found.data, **held)
    space = result.space
    for group in ("posterior", "prior"):
        for k, name in enumerate(space.names):
            tree[group][name].attrs.update(range=[float(space.low[k]), float(space.high[k])], unit=space.units[k] or "")
    return tree


def _by_name(result: Record, theta: NDArray[np.float64]) -> Group:
    return {name: column[None] for name, column in zip(result.space.names, theta.T)}


def _last_weighted(result: Record) -> Iteration:
    assert result.most_probable is not None, "there is a posterior"
    return result.iterations[result.most_probable.iteration]


def _responses(result: Record, number: int, rows: NDArray[np.intp]) -> NDArray[np.float64]:
    """What samples of the last iteration with weights gave in an experiment, at the rows of its reference: (len(rows), T, J)."""
    samples, drawn = _last_weighted(result).samples, np.unique(rows)
    given = [response for row in drawn if isinstance(response := result.response(int(samples.ids[row]), number), Response)]
    assert len(given) == len(drawn), "what carries weight has a response"
    met = result.experiments[number].observables_of(given)
    return met[np.searchsorted(drawn, rows)]
