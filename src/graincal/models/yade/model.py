"""An installed YADE as a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from graincal.data import InputError
from graincal.models.command.model import CommandModel
from graincal.models.command.work import CommandWork
from graincal.models.contact_laws import LAWS
from graincal.models.output import Column, Output
from graincal.models.rests import REST_EVERY, strains_at_rest
from graincal.models.stress_path import RETURNED, checked_strains
from graincal.suggestion import did_you_mean

TRIAXIAL_SCRIPT = Path(__file__).with_name("triaxial_script.py")
"""The paper's triaxial test, by YADE."""

TABLE, LINE = "parameters.table", 2
"""The file that a script's `readParamsFromTable` is led to, and the line of it that has the values, counted as YADE counts."""

PARAMETERS = LAWS["linear"].names
"""Of either law that the test can have."""

WITHOUT_ROLLING = ("beta_m", "eta_m")
"""Parameters that must be 0 with YADE's Hertz-Mindlin."""


@dataclass(frozen=True, eq=False)
class YadeModel(CommandModel):
    """YADE, which runs a script for each sample: `triaxial` for graincal's own, `script` for one of the user's.

    table: names of the parameters, or derived values, that the script reads by `readParamsFromTable`, as in YADE's batch. rest_every: the strain from one state at rest to the next, of graincal's own script, which is
    told the states that the reference needs; None for others. law: its contact law. All else is as of any program.
    """

    table: tuple[str, ...] = ()
    rest_every: float | None = None
    law: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "table", tuple(self.table))

    @property
    def _written(self) -> list[str]:
        return [*super()._written, *([TABLE] if self.table else [])]

    def described(self) -> dict[str, Any]:
        """It as plain data (what JSON holds)."""
        return {**super().described(), "kind": "yade"}

    def _work(self, parameters: Sequence[str], at: ArrayLike) -> CommandWork:
        if self.link and not (path := (self.folder / self.link[0]).absolute()).exists():
            raise InputError(f"script names {self.link[0]}, and there is no {path}.")
        work = super()._work(parameters, at)
        if self.table:
            known = [*parameters, *self.derived]
            if unknown := [name for name in self.table if name not in known]:
                raise InputError(
                    f"table names {unknown[0]}{did_you_mean(unknown[0], known)}, which is no parameter and not derived, and some of {', '.join(known)} were expected."
                )
            begin, end = self.delimiters
            text = f"{' '.join(self.table)}\n{' '.join(f'{begin} {name} {end}' for name in self.table)}\n"
            inputs = replace(
                work.inputs, templates={**work.inputs.templates, TABLE: text}, environment={**work.inputs.environment, "YADE_BATCH": f"{TABLE}:{LINE}"}
            )
            inputs.check(parameters)
            work = replace(work, inputs=inputs)
        if self.rest_every is not None:
            self._check_parameters(parameters)
            strains = strains_at_rest(checked_strains(at), self.rest_every)
            told = ("--strains", ",".join(map(repr, strains.tolist())))
            work = replace(work, inputs=replace(work.inputs, command=(*work.inputs.command, *told)))
        return work

    def _check_parameters(self, parameters: Sequence[str]) -> None:
        """Raise InputError for parameters that graincal's own script does not take; those that it lacks are missed by whoever fills in its arguments."""
        taken = [name for name in PARAMETERS if _told(name) in self.command]
        if unknown := [name for name in parameters if name not in taken]:
            raise InputError(
                f"a triaxial test by YADE takes the parameters {', '.join(taken) or 'that are not fixed'}, and {unknown[0]} is not one of them{did_you_mean(unknown[0], taken)}."
            )


def _told(name: str) -> str:
    """The argument that tells graincal's own script a parameter."""
    return f"-p={name}={{{{ {name} }}}}"


def triaxial(
    packing: Path,
    confining_pressure: float,
    density_scaling: float,
    *,
    fixed: Mapping[str, float] | None = None,
    law: str = "linear",
    rest_every: float = REST_EVERY,
    program: str = "yade",
    cores: int = 1,
    **options: Any,
) -> YadeModel:
    """The paper's drained triaxial test on the packing of a file, by YADE. confining_pressure: Pa. density_scaling: factor on the grains' density. fixed: parameters that are not calibrated. options: those of `CommandModel`.

    Raises InputError for fixed values that mean nothing.
    """
    fixed = dict(fixed or {})
    if law == "hertz-mindlin":
        if rolling := [name for name in WITHOUT_ROLLING if fixed.get(name, 0.0) != 0.0]:
            raise InputError(f'fixed.{rolling[0]} must be 0 or left out: YADE\'s "hertz-mindlin" has no resistance to rolling.')
        fixed |= dict.fromkeys(WITHOUT_ROLLING, 0.0)
    for name, value in fixed.items():
        if name not in PARAMETERS:
            raise InputError(f"fixed: {name} is not among the test's parameters {', '.join(PARAMETERS)}{did_you_mean(name, PARAMETERS)}.")
        if (parameter := LAWS[law].parameter(name)).excludes(value):
            raise InputError(f"fixed.{name} must be a number {parameter.limits}, not {value!r}{parameter.meant(value)}.")
    packing = packing.absolute()
    given = [f"-p={name}={fixed[name]!r}" if name in fixed else _told(name) for name in PARAMETERS]
    test = [
        "--packing",
        packing.name,
        "--confining-pressure",
        repr(float(confining_pressure)),
        "--density-scaling",
        repr(float(density_scaling)),
        "--cell-inertia",
        "graincal",
        "--law",
        law,
    ]
    command = (program, "-n", "-x", f"-j{cores}", TRIAXIAL_SCRIPT.name, "--", *test, *given, "-o", "curve.csv")
    output = Output({name: Column(name) for name in RETURNED if name != "contacts"}, "curve.csv")
    return YadeModel(command, output, link=(str(TRIAXIAL_SCRIPT), str(packing)), cores=cores, rest_every=rest_every, law=law, **options)


def script(
    path: str,
    output: Output,
    *,
    arguments: Sequence[str] = (),
    table: Sequence[str] = (),
    program: str = "yade",
    cores: int = 1,
    link: Sequence[str] = (),
    **options: Any,
) -> YadeModel:
    """A script of the user's, beside the calibration file, as it is. arguments: its own, in which `{{ name }}` stands for a parameter. table: the names that its `readParamsFromTable` reads. Others as of `CommandModel`.

    Raises InputError where it is told no parameters.
    """
    if not table and not any("{{" in text for text in arguments) and not any(options.get(key) for key in ("templates", "parameters_file", "environment")):
        raise InputError(
            f'{path} is told no parameters: table = ["E", "phi"] for a script that calls readParamsFromTable, or arguments = ["{{{{ E }}}}"] was expected.'
        )
    name = Path(path).name
    command = (program, "-n", "-x", f"-j{cores}", name, *(["--", *arguments] if arguments else []))
    return YadeModel(command, output, link=(path, *link), table=tuple(table), cores=cores, **options)
