"""graincal simulate: one test at given parameters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from graincal.data import InputError

if TYPE_CHECKING:
    from graincal.data import Reference, Response

simulate = typer.Typer(no_args_is_help=True, help="Simulate one test at given parameters.")
EXAMPLE = (
    "Example:  graincal simulate triaxial --packing packing.csv --confining-pressure 0.5e6"
    " -p log_E=8.72 -p nu=0.227 -p phi=28.1 -p beta_m=0.079 -p eta_m=0.569 -o curve.csv"
)


@simulate.command(epilog=EXAMPLE)
def triaxial(
    packing: Annotated[Path, typer.Option(help="A packing file: x,y,z,radius in metres.", metavar="FILE")],
    confining_pressure: Annotated[float, typer.Option(help="In Pa.")],
    parameters: Annotated[list[str], typer.Option("-p", help="log_E, nu, phi (deg), beta_m, eta_m: each once.", metavar="NAME=VALUE")],
    axial_strain: Annotated[float | None, typer.Option(help="The last axial strain, logarithmic, as a fraction.", show_default="0.2")] = None,
    increment: Annotated[float | None, typer.Option(help="The axial strain between recorded states.", show_default="0.004")] = None,
    at: Annotated[Path | None, typer.Option(help="Record at the axial strains of this reference instead, and say how far from it the curve is: a calibration file (.toml), or a laboratory file with graincal's own column names and logarithmic strain.", metavar="FILE")] = None,
    density_scaling: Annotated[float, typer.Option(help="Factor on the grains' density.")] = 1e3,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The curve as CSV; printed if there is neither -o nor --plot.", metavar="FILE")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the curve to this file (.png, .pdf, .svg).", metavar="FILE")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors and the curve.")] = False,
) -> None:
    """A drained triaxial test of a packing by graincal's own engine."""
    import numpy as np

    from graincal import Packing, TriaxialTest
    from graincal.cli.comparison import read_comparison
    from graincal.data import Failure, Samples

    theta = _parse(parameters)
    if at and (axial_strain is not None or increment is not None):
        raise InputError("--at gives the axial strains, so --axial-strain and --increment cannot stand beside it.")
    reference = read_comparison(at, confining_pressure) if at else None
    strains = reference.control if reference else _strains(0.20 if axial_strain is None else axial_strain, 0.004 if increment is None else increment)
    # A state that is not at rest is a warning here, for a person looks at the curve.
    test = TriaxialTest(Packing.read(packing), confining_pressure, density_scaling, largest_flagged_share=1.0)
    samples = Samples(np.zeros(1, dtype=np.int64), np.array([list(theta.values())]), tuple(theta))
    ((_, outcome),) = test.evaluate(samples, at=strains, workers=1)
    if isinstance(outcome, Failure):
        raise InputError(f"The simulation gave no curve: {outcome.reason}")
    _write(outcome, output, plot, reference)
    if not quiet:
        typer.echo("\n".join(_describe(outcome, reference)), err=True)


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


def _strains(last: float, increment: float):
    import numpy as np

    if not 0 < increment <= last < 1:
        raise InputError(f"--axial-strain and --increment must be fractions with 0 < increment <= strain < 1, not {last:g} and {increment:g}.")
    states = round(last / increment)
    return np.append(increment * np.arange(states), last) if abs(states * increment - last) < 1e-9 else np.append(np.arange(0, last, increment), last)


def _write(curve: Response, output: Path | None, plot: Path | None, reference: Reference | None) -> None:
    from graincal.campaign.curves import as_table, write_curve

    if output is not None:
        write_curve(output, curve)
    elif plot is None:
        typer.echo(as_table(curve), nl=False)
    if plot is not None:
        from graincal.cli.figures import draw_response

        draw_response(curve, plot, "axial_strain", reference)


def _describe(curve: Response, reference: Reference | None) -> list[str]:
    from graincal.cli.text import duration

    lines = [f"{len(curve.control)} states, {curve.details['steps']:,.0f} steps, {duration(curve.details['seconds'])}"]
    if flagged := int(curve.details["flagged"]):
        lines.append(f"Warning: {flagged} of {len(curve.control)} states were not at rest within their step limit (column flagged).")
    if reference is not None:
        from graincal.inference.errors import observable_errors, sample_errors

        errors = observable_errors(curve.observables(reference.names)[None], reference)
        each = ", ".join(f"{name} {error:.2f} %" for name, error in zip(reference.names, errors[0]))
        lines.append(f"Error against the reference: {each}; together {sample_errors(errors, reference.shares)[0]:.2f} %")
    return lines
