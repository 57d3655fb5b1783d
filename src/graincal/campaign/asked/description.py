"""Calibrations as plain data (what JSON holds) and back, so that a campaign's folder needs nothing beside it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.asked.experiment import Experiment
from graincal.data import InputError, MeasurementError, ParameterSpace, Reference, Samples
from graincal.dem.packing import Packing
from graincal.dem.stress_path_table import StressPathTable
from graincal.execution import Task
from graincal.inference import Stop
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.posterior.first_look import FirstLook
from graincal.models import TESTS, ByHandModel, CommandModel, Model, PythonModel, StressPathTest, TableTest, YadeModel
from graincal.models.compression import CompressionTest
from graincal.parameter_space import LINEAR

PROGRAMS = {"command": CommandModel, "yade": YadeModel}
"""Models that are programs, by their kinds."""


def describe(calibration: Calibration) -> dict[str, Any]:
    """Everything that determines what the campaign finds. Numbers keep every digit; equal calibrations have equal descriptions."""
    return {
        "parameters": _describe_parameters(calibration.space),
        # Left out where there are none.
        **({"constraints": constraints} if (constraints := [each.source for each in calibration.space.of_experiment(0).constraints]) else {}),
        "experiments": [
            {"name": experiment.name, "reference": _describe_reference(experiment.reference), "model": describe_model(experiment.model)}
            for experiment in calibration.experiments
        ],
        "method": calibration.method,
        "filter": calibration.decided_options,
        "stop": describe_stop(calibration.method, calibration.stop),
        "seed": int(calibration.seed),
        # Left out where there is none.
        **({"first_look": describe_first_look(calibration.first_look)} if calibration.first_look else {}),
        **({"look": describe(calibration.look)} if calibration.look else {}),
        **({"known": _describe_known(calibration.known)} if calibration.known else {}),
    }


def describe_stop(method: str, stop: Stop) -> dict[str, Any]:
    """The criteria of stopping."""
    # Without the one that the paper's method does not look at, and with the limit that it has by itself.
    if method == POSTERIOR:
        return asdict(stop)
    return {name: limit for name, limit in asdict(stop).items() if name != "posterior_shift"} | {"max_iterations": stop.most_iterations}


def restore(description: Mapping[str, Any], **others: Any) -> Calibration:
    """The calibration that was described; `others` are its fields that a description leaves out."""
    parameters = description["parameters"]
    space = ParameterSpace(
        {p["name"]: p["fixed"] if "fixed" in p else tuple(p["range"]) for p in parameters},
        {p["name"]: p["unit"] for p in parameters},
        [p["name"] for p in parameters if p.get("per_experiment")],
        scale={p["name"]: p["scale"] for p in parameters if "scale" in p},
        constraints=description.get("constraints", ()),
    )
    experiments = [Experiment(e["name"], _restore_model(e["model"]), _restore_reference(e["reference"])) for e in description["experiments"]]
    found = description.get("first_look")
    first_look = FirstLook(np.array(found["theta"]), tuple(map(np.array, found["responses"]))) if found else None
    look = restore(description["look"]) if "look" in description else None
    stop = Stop(**description["stop"])
    return Calibration(space, experiments, description["method"], description["filter"], stop, description["seed"], first_look=first_look, look=look, **others)


@dataclass(frozen=True)
class AbsentModel(Model):
    """A model that was handed over in Python, and of which a store can only keep the name."""

    name: str

    def tasks(self, samples: Samples, at: ArrayLike) -> list[Task]:
        """Raise InputError: there is nothing to evaluate with."""
        raise InputError(f"its model ({self.name}) was handed over in Python, so that it must be again: graincal.resume(folder, model).")


def _describe_parameters(space: ParameterSpace) -> list[dict[str, Any]]:
    """The parameters as they were given; those with a value for each experiment are told apart again by the experiments' names."""
    given = space.of_experiment(0)
    unknown = {
        # Left out where it is false, or the usual one.
        name: {
            "range": [float(low), float(high)],
            "unit": unit,
            **({"scale": scale} if scale != LINEAR else {}),
            **({"per_experiment": True} if name in space.per_experiment else {}),
        }
        for name, low, high, unit, scale in zip(given.names, given.low, given.high, given.units, given.scales)
    }
    fixed = {name: {"fixed": value, "unit": given.units_of_fixed[name]} for name, value in given.fixed.items()}
    return [{"name": name} | (unknown | fixed)[name] for name in given.order]


def _describe_reference(reference: Reference) -> dict[str, Any]:
    return {
        "control_name": reference.control_name,
        "control": reference.control.tolist(),
        "observables": {name: values.tolist() for name, values in reference.observables.items()},
        "variance_shares": dict(reference.variance_shares),
        "measurement_errors": {name: _describe_error(error) for name, error in reference.measurement_errors.items()},
        "notes": list(reference.notes),
        # Left out where nothing is said.
        **({"control_step": reference.control_step} if reference.control_step else {}),
        **({"simulated": True} if reference.simulated else {}),
        **({"cut": True} if reference.cut else {}),
        **({"recorded": {name: values.tolist() for name, values in reference.recorded.items()}} if reference.recorded else {}),
        **{key: list(said) for key in ("at_pressure", "turned") if (said := getattr(reference, key))},
    }


def _describe_error(error: MeasurementError) -> float | dict[str, float]:
    """A plain number where it is nothing but a standard deviation."""
    given = {name: float(value) for name, value in asdict(error).items() if value}
    return given["absolute"] if list(given) == ["absolute"] else given


def _restore_reference(described: Mapping[str, Any]) -> Reference:
    return Reference(
        described["control"],
        described["observables"],
        described["variance_shares"],
        {name: MeasurementError(**error) if isinstance(error, dict) else error for name, error in described["measurement_errors"].items()},
        control_name=described["control_name"],
        control_step=described.get("control_step", 0.0),
        simulated=described.get("simulated", False),
        recorded=described.get("recorded"),
        notes=tuple(described["notes"]),
        cut=described.get("cut", False),
        at_pressure=tuple(described.get("at_pressure", ())),
        turned=tuple(described.get("turned", ())),
    )


def _describe_known(runs: KnownRuns) -> dict[str, Any]:
    """By a digest of all their numbers, which a store keeps beside."""
    digest = hashlib.sha256(
        b"".join(np.ascontiguousarray(array).tobytes() for array in (runs.theta, *runs.responses, runs.infeasible, runs.missing))
    ).hexdigest()
    return {"count": len(runs), "digest": digest, "sources": list(runs.sources)}


def describe_first_look(look: FirstLook) -> dict[str, Any]:
    return {"theta": look.theta.tolist(), "responses": [responses.tolist() for responses in look.responses]}


def _describe_packing(packing: Packing) -> dict[str, Any]:
    return {name: getattr(packing, name).tolist() for name in ("positions", "radii", "edges")} | {"name": packing.name}


def _restore_packing(described: Mapping[str, Any]) -> Packing:
    return Packing(np.array(described["positions"]), np.array(described["radii"]), np.array(described["edges"]), described["name"])


def describe_model(model: Model) -> dict[str, Any]:
    """What its runs depend on."""
    if isinstance(model, StressPathTest) and type(model) is TESTS.get(getattr(model, "kind", "")):
        described = {
            "kind": model.kind,
            "packing": _describe_packing(model.first_packing),
            # Those beside the first.
            **({"more_packings": [_describe_packing(packing) for packing in model.packings[1:]]} if len(model.packings) > 1 else {}),
            "confining_pressure": None if model.confining_pressure is None else float(model.confining_pressure),
            # As they are in effect, so that other defaults of another version change nothing.
            **model.density,
            "rest_every": model.strain_between_rests,
            **model.settings,
            "fixed": dict(model.fixed),
            "largest_flagged_share": model.largest_flagged_share,
            "step_limit": model.step_limit,
            "law": model.law,
            "control": model.control,
        }
        if isinstance(model, CompressionTest) and model.turns:
            # Left out where there are none.
            described["turns"] = list(model.turns)
        if isinstance(model, TableTest):
            described["table"] = asdict(model.table)
        return described
    if isinstance(model, (CommandModel, ByHandModel)):
        return model.described()
    if isinstance(model, PythonModel) and isinstance(model.function, str):
        control = None if model.control is None else np.asarray(model.control).tolist()
        folder = str(model.folder.resolve()) if model.folder else None
        timeout = {} if model.timeout is None else {"timeout": model.timeout}  # left out for the same reason
        return {"kind": "python", "function": model.function, "folder": folder, "control": control, **timeout}
    named = model.function if isinstance(model, PythonModel) else type(model)
    return {"kind": "absent", "name": f"{named.__module__}.{getattr(named, '__qualname__', type(named).__qualname__)}"}


def _restore_model(described: Mapping[str, Any]) -> Model:
    options = {key: value for key, value in described.items() if key != "kind"}
    if described["kind"] in TESTS:
        packings = [_restore_packing(packing) for packing in (options.pop("packing"), *options.pop("more_packings", ()))]
        if "table" in options:
            options["table"] = StressPathTable.restore(**options["table"])
        return TESTS[described["kind"]](packings, **options)
    if described["kind"] in PROGRAMS:
        return PROGRAMS[described["kind"]].restored(described)
    if described["kind"] == "python":
        folder = Path(options["folder"]) if options["folder"] else None
        return PythonModel(options["function"], options["control"], folder=folder, timeout=options.get("timeout"))
    if described["kind"] == "by-hand":
        return ByHandModel.restored(described)
    return AbsentModel(described["name"])
