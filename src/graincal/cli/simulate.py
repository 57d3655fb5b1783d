"""graincal simulate: one test at given parameters, by a command for each stress path."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from graincal.cli.columns import Column, Compression, Measure, Rows, Sheet, Stage, said_of_file
from graincal.cli.saying import say
from graincal.cli.strains import axial_strains
from graincal.data import InputError
from graincal.models import StressPathTest
from graincal.models.contact_laws import LAWS
from graincal.models.economy import INERTIAL_NUMBER, Economy

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from graincal.data import Reference, Response

simulate = typer.Typer(no_args_is_help=True, help="Simulate one test at given parameters.")

ConfiningPressure = Annotated[float, typer.Option(help="Pressure of the isotropic consolidation that the path begins with, in Pa.")]
AxialStrain = Annotated[float, typer.Option(help="The last axial strain, logarithmic, as a fraction; below 0 in extension.")]
Increment = Annotated[float, typer.Option(help="The axial strain between the rows of the curve.")]


@dataclass(frozen=True)
class Simulation:
    """The options of every path: what is simulated, and where the curve goes."""

    packing: Annotated[Path, typer.Option(help="A packing file: x,y,z,radius in metres.", metavar="FILE")]
    parameters: Annotated[list[str], typer.Option("-p", help="log_E, nu, phi (deg), beta_m, eta_m: each once.", metavar="NAME=VALUE")]
    law: Annotated[str, typer.Option(help=f"The contact law: {' or '.join(LAWS)}.", metavar="NAME")] = StressPathTest.law
    rest_every: Annotated[
        float | None, typer.Option(help="The strain from one state at rest to the next; rows between them are interpolated.", show_default="0.004")
    ] = None
    accuracy: Annotated[str, typer.Option(help="standard; or reference, step by step as YADE, nearly twice as long.", metavar="NAME")] = Economy.accuracy
    inertial_number: Annotated[
        float | None, typer.Option(help="Inertial number of the axial loading; the grains' density follows from it.", show_default=f"{INERTIAL_NUMBER:g}")
    ] = None
    density_scaling: Annotated[float | None, typer.Option(help="Factor on the grains' density, instead of the inertial number.")] = None
    time_step_bound: Annotated[
        str | None, typer.Option(help="grain: as YADE; contact: closer to the true limit, so larger steps.", metavar="NAME", show_default="by accuracy")
    ] = None
    mass_exponent: Annotated[
        float | None,
        typer.Option(help="Grains' masses go with this power of the radius; below 3, small grains limit the time step less.", show_default="by accuracy"),
    ] = None
    precision: Annotated[
        str | None, typer.Option(help="Precision of forces and velocities: float64 or float32.", metavar="NAME", show_default="by accuracy")
    ] = None
    inertia_factor: Annotated[float, typer.Option(help="Factor on the grains' moments of inertia.")] = Economy.inertia_factor
    settling_damping: Annotated[float, typer.Option(help="Damping once every axis has arrived.")] = Economy.settling_damping
    strain_ramp: Annotated[float, typer.Option(help="Share of each strain increment over which its rate rises, and falls.")] = Economy.strain_ramp
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The curve as CSV; printed if there is neither -o nor --plot. Nothing is overwritten.", metavar="FILE")
    ] = None
    plot: Annotated[Path | None, typer.Option(help="Draw the curve to this file (.png, .pdf, .svg); nothing is overwritten.", metavar="FILE")] = None
    vtk: Annotated[
        Path | None,
        typer.Option(
            help="Write the particles and contacts at the start and at each state at rest, for ParaView, to this folder; it runs the test once more.",
            metavar="FOLDER",
        ),
    ] = None
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors and the curve.")] = False

    def run(self, kind: str, at: ArrayLike, reference: Reference | None = None, **options: Any) -> None:
        """Run the test of that kind, with its own options, through the control values `at`, and write what it gave there."""
        import numpy as np

        from graincal import Packing
        from graincal.cli.outputs import check_folder, check_outputs
        from graincal.data import Failure, Response, Samples
        from graincal.interpolation import interpolate
        from graincal.models import TESTS
        from graincal.models.pictures import write_pictures

        theta = _parse(self.parameters)
        check_outputs(self.output, self.plot)
        if self.vtk is not None:
            check_folder(self.vtk)
            if self.vtk.is_dir() and any(self.vtk.iterdir()):
                raise InputError(f"{self.vtk}: this folder holds files, and --vtk expected one that is empty or not there.")
        # A state that is not at rest is a warning here, for a person looks at the curve.
        shared = {field.name: getattr(self, field.name) for field in fields(self) if field.name in _OF_THE_TEST}
        test = TESTS[kind](Packing.read(self.packing), largest_flagged_share=1.0, **shared, **options)
        for doubt in [] if self.quiet else _doubts(test, theta, at):
            say(f"Note: {doubt}", err=True)
        samples = Samples(np.zeros(1, dtype=np.int64), np.array([list(theta.values())]), tuple(theta))
        ((_, outcome),) = test.evaluate(samples, at=at, workers=1)
        if isinstance(outcome, Response):
            outcome = interpolate(outcome, np.asarray(at, dtype=np.float64))
        if isinstance(outcome, Failure):
            raise InputError(f"The simulation gave no curve: {outcome.reason}")
        _write(outcome, test, self.output, self.plot, reference)
        pictures = [] if self.vtk is None else write_pictures(test, test.arrange(samples)[0], at, self.vtk)
        if not self.quiet:
            written = [f"Written to {path}." for path in (self.output, self.plot, *pictures) if path is not None]
            say("\n".join([*_describe(outcome, reference), *written]), err=True)

    def say_what_differs(self, path: Path, settings: Mapping[str, Any]) -> None:
        """Only rows are read from a calibration file: name the settings of its model that are others here."""
        differ = [name for name in _OF_THE_TEST if name in settings and settings[name] != getattr(self, name)]
        if differ and not self.quiet:
            options = " ".join(f"--{name.replace('_', '-')} {settings[name]}" for name in differ)
            say(f"Note: only the rows are taken from {path}. For the settings of its model add {options}.", err=True)


_OF_THE_TEST = (
    "law", "rest_every", "accuracy", "inertial_number", "density_scaling", "time_step_bound", "mass_exponent", "precision", "inertia_factor", "settling_damping", "strain_ramp",
)  # fmt: skip
"""Options of every path that are fields of the test."""


def _path(example: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Makes a command of a function whose first argument is the Simulation: the command has that one's options beside the function's own."""

    def register(function: Callable[..., None]) -> Callable[..., None]:
        name = function.__name__.replace("_", "-")

        def command(**given: Any) -> None:
            shared = {field.name: given.pop(field.name) for field in fields(Simulation)}
            function(Simulation(**shared), **given)

        command.__doc__ = function.__doc__
        parameters = _options(Simulation) + _options(function)[1:]
        # What typer reads the options from.
        setattr(command, "__signature__", inspect.Signature(parameters))  # noqa: B010
        epilog = f"Example:  graincal simulate {name} --packing packing.csv {example} -p log_E=8.72 -p nu=0.227 -p phi=28.1 -p beta_m=0.079 -p eta_m=0.569 -o curve.csv"
        simulate.command(name, epilog=epilog)(command)
        return function

    return register


def _options(function: Callable[..., Any]) -> list[inspect.Parameter]:
    """A function's or dataclass' arguments, their annotations resolved."""
    hints = get_type_hints(function, include_extras=True)
    return [
        parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[name]) for name, parameter in inspect.signature(function).parameters.items()
    ]


@_path("--confining-pressure 0.5e6")
def triaxial(
    simulation: Simulation,
    confining_pressure: ConfiningPressure,
    axial_strain: Annotated[
        float | None, typer.Option(help="The last axial strain, logarithmic, as a fraction; below 0 in extension.", show_default="0.2")
    ] = None,
    increment: Annotated[float | None, typer.Option(help="The axial strain between the rows of the curve.", show_default="0.004")] = None,
    at: Annotated[
        Path | None,
        typer.Option(
            help="The rows of this reference instead, and say how far from it the curve is: a calibration file (.toml), whose rows alone are read, or a laboratory file, by its own column names or by --column.",
            metavar="FILE",
        ),
    ] = None,
    column: Column = None,
    strain: Measure = None,
    compression: Compression = None,
    stage: Stage = None,
    rows: Rows = None,
    sheet: Sheet = None,
) -> None:
    """A drained triaxial test: the lateral stresses are held while the axial strain is imposed, in compression or extension."""
    asked = said_of_file("--at", at, column, strain, compression, stage, rows, sheet)
    if at and (axial_strain is not None or increment is not None):
        raise InputError("--at gives the axial strains, so --axial-strain and --increment cannot stand beside it.")
    if at:
        from graincal.cli.comparison import Compared, read_comparison, settings_of

        test = Compared.drained(confining_pressure)
        reference = read_comparison(at, test, asked=asked)
        simulation.say_what_differs(at, settings_of(at, test))
        simulation.run("triaxial", reference.control, reference, confining_pressure=confining_pressure)
    else:
        strains = axial_strains(0.20 if axial_strain is None else axial_strain, 0.004 if increment is None else increment)
        simulation.run("triaxial", strains, confining_pressure=confining_pressure)


@_path("--confining-pressure 0.5e6 --axial-strain 0.10")
def constant_mean_stress(simulation: Simulation, confining_pressure: ConfiningPressure, axial_strain: AxialStrain = 0.20, increment: Increment = 0.004) -> None:
    """A triaxial test at constant mean stress: the lateral stresses make up for the axial one."""
    simulation.run("constant-mean-stress", axial_strains(axial_strain, increment), confining_pressure=confining_pressure)


@_path("--confining-pressure 0.5e6 --axial-strain 0.10")
def undrained(simulation: Simulation, confining_pressure: ConfiningPressure, axial_strain: AxialStrain = 0.20, increment: Increment = 0.004) -> None:
    """An undrained triaxial test of a saturated sample, by its equivalent at constant volume: stresses are effective ones."""
    simulation.run("undrained", axial_strains(axial_strain, increment), confining_pressure=confining_pressure)


@_path("--confining-pressure 1e4 --axial-stress 1e5 --axial-stress 8e5 --axial-stress 1e5")
def oedometric(
    simulation: Simulation,
    confining_pressure: ConfiningPressure,
    axial_strain: Annotated[float | None, typer.Option(help="The last axial strain, logarithmic, as a fraction.")] = None,
    increment: Increment = 0.004,
    axial_stress: Annotated[list[float] | None, typer.Option(help="Load to this axial stress instead, in Pa; once for each, up and down.")] = None,
) -> None:
    """One-dimensional compression without lateral strain, to an axial strain or to axial stresses."""
    if (axial_strain is None) == (not axial_stress):
        raise InputError(f"either --axial-strain or --axial-stress was expected, and {'neither is' if axial_strain is None else 'both are'} given.")
    if axial_stress:
        simulation.run("oedometric", axial_stress, confining_pressure=confining_pressure, control="axial_stress")
    elif axial_strain is not None:
        simulation.run("oedometric", axial_strains(axial_strain, increment), confining_pressure=confining_pressure)


@_path("--confining-pressure 5e4 --pressure 1e5 --pressure 8e5 --pressure 1e5")
def isotropic(
    simulation: Simulation,
    confining_pressure: ConfiningPressure,
    pressure: Annotated[list[float], typer.Option(help="Load to this pressure, in Pa; once for each, up and down.")],
) -> None:
    """Isotropic compression to a list of pressures."""
    simulation.run("isotropic", pressure, confining_pressure=confining_pressure)


@_path("--table path.csv --confining-pressure 1e5")
def table(
    simulation: Simulation,
    table: Annotated[Path, typer.Option(help="A row for each stage, CSV: stress_x or strain_x, rate_x, ... and record.", metavar="FILE")],
    confining_pressure: Annotated[
        float | None, typer.Option(help="Pressure of an isotropic consolidation before the table's first row, in Pa; none without it.")
    ] = None,
) -> None:
    """A stress path of your own: a table with a stress or a strain of each axis for each stage."""
    from graincal import StressPathTable

    stages = StressPathTable.read(table)
    simulation.run("table", stages.recorded, confining_pressure=confining_pressure, table=stages)


def _parse(parameters: list[str]) -> dict[str, float]:
    theta = {}
    for text in parameters:
        name, _, value = text.partition("=")
        try:
            number = float(value)
        except ValueError:
            raise InputError(f"-p {text}: NAME=VALUE with a number was expected, such as -p phi=28.1.") from None
        if name in theta:
            raise InputError(f"-p {text}: {name} is given twice.")
        theta[name] = number
    return theta


def _doubts(test: StressPathTest, theta: Mapping[str, float], at: ArrayLike) -> list[str]:
    """What is to be said of a pressure or modulus that another unit was probably meant for; of stresses, of the smallest and the largest."""
    import numpy as np

    from graincal.models.contact_laws import unusual_parameters
    from graincal.models.plausibility import unusual_pressure
    from graincal.models.stress_path import unusual

    said: list[str | None] = [*unusual_parameters({name: (value,) for name, value in theta.items()})]
    if test.control.endswith("stress"):
        said += [unusual_pressure(test.control, value) for value in sorted({float(np.min(at)), float(np.max(at))}) if value > 0]
    return unusual(test) + [doubt for doubt in said if doubt]


def _write(curve: Response, test: StressPathTest, output: Path | None, plot: Path | None, reference: Reference | None) -> None:
    from graincal.campaign.stored.curves import as_table, write_curve

    if output is not None:
        write_curve(output, curve, test.control)
    elif plot is None:
        say(as_table(curve, test.control), prose=False, nl=False)
    if plot is not None:
        from graincal.cli.figures import draw_response

        draw_response(curve, plot, test.control, test.shown, reference)


def _describe(curve: Response, reference: Reference | None) -> list[str]:
    from graincal.notation.text import duration

    lines = [
        f"{len(curve.control)} rows from {curve.details['states']:.0f} states at rest, {curve.details['steps']:,.0f} steps, {duration(curve.details['seconds'])}"
    ]
    if flagged := int(curve.details["flagged"]):
        lines.append(f"Warning: {flagged} of {curve.details['states']:.0f} states were not at rest within their step limit (column flagged).")
    if reference is not None:
        from graincal.inference.likelihood.errors import curve_error, observable_errors, sample_errors

        errors = observable_errors(curve.observables(reference.names)[None], reference)
        each = ", ".join(f"{name} {error:.2f} %" for name, error in zip(reference.names, errors[0]))
        lines += [f"The reference: {note}" for note in reference.notes]
        lines.append(f"Error against the reference: {each}; together {sample_errors(errors, reference.shares)[0]:.2f} %")
        if reference.recorded:
            beside = ", ".join(f"{name} {curve_error(curve.values[name], values):.2f} %" for name, values in reference.recorded.items())
            lines.append(f"Error of what is not fitted: {beside}")
    return lines
