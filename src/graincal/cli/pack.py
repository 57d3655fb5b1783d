"""graincal pack."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Quiet
from graincal.cli.saying import say
from graincal.data import InputError
from graincal.files import unwritable


def pack(
    particles: Annotated[int, typer.Option(min=2, help="How many spheres; what the grading needs at the least is said where they are too few.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The packing file to write; nothing is overwritten.", metavar="FILE")],
    void_ratio: Annotated[float | None, typer.Option(help="Volume of voids over volume of solids, before the test's own compression.")] = None,
    relative_density: Annotated[
        float | None, typer.Option(help="Relative density, instead of a void ratio: 0 for the loosest, 1 for the densest packing of the grading's spheres.")
    ] = None,
    grading: Annotated[
        str,
        typer.Option(
            help="toyoura, d50=0.14,Cu=1.5 (in mm), or a CSV file with the columns 'size \\[mm],passing \\[%]'. The built-in toyoura is enlarged to grains of 3.4 to 9.6 mm: only their ratios matter."
        ),
    ] = "toyoura",
    seed: Annotated[int, typer.Option(min=0, help="Seed: another seed gives another packing.")] = 1,
    quiet: Quiet = False,
) -> None:
    """Prepare a packing: a cloud of the grading is compacted, and friction lowered until the void ratio is met.

    The same request gives the same packing, which is kept in the cache folder ($GRAINCAL_CACHE, or ~/.cache/graincal/packings).
    """
    from graincal.cli.outputs import check_file
    from graincal.cli.preparing import said_of_loose
    from graincal.dem.grading import Grading
    from graincal.dem.preparation import OutOfReach, comment, prepare, reach, write_whole

    check_file(output)
    by_void_ratio = void_ratio is not None
    void_ratio, asked = _asked(particles, grading, void_ratio, relative_density, quiet)
    try:
        packing = prepare(particles, void_ratio, grading, seed)
    except OutOfReach as error:
        advice = " --relative-density asks for a packing as dense among these as a sample is among its own." if by_void_ratio else ""
        raise InputError(f"{error}{advice}") from None
    try:
        write_whole(packing, output, comment(void_ratio, grading, seed))
    except OSError as error:
        raise InputError(unwritable(output, error)) from None
    if not quiet:
        x, y, z = (1e3 * length for length in packing.edges.diagonal())
        diameters = 2e3 * packing.radii
        say(f"{packing.count} particles of {diameters.min():.3g} to {diameters.max():.3g} mm in a cell of {x:.4g} x {y:.4g} x {z:.4g} mm")
        if (enlarged := Grading.named(grading).enlarged) != 1:
            say(
                f"These grains are about {enlarged:g} times as large as those of {grading} sand: only the ratios of their sizes matter, and none is scaled back."
            )
        say(f"void ratio {packing.void_ratio:.4f} (asked for {asked})")
        if note := said_of_loose(reach(particles, grading), void_ratio):
            say(note)
        say(f"Written to {output}.")


def _asked(particles: int, grading: str, void_ratio: float | None, relative_density: float | None, quiet: bool) -> tuple[float, str]:
    """The void ratio that is asked for, and in words what was. Raises InputError where it is neither or both, or where no packing has such a relative density."""
    from graincal.cli.preparing import check_relative_density, reach_of

    if void_ratio is not None and relative_density is None:
        return void_ratio, f"{void_ratio:g}"
    if relative_density is None or void_ratio is not None:
        raise InputError("pack: one of --void-ratio and --relative-density was expected.")
    check_relative_density(relative_density)
    found = reach_of(particles, grading, quiet=quiet)
    # Of one seed, so that packings of other seeds have the same void ratio.
    void_ratio = round(found.void_ratio(relative_density), 4)
    return void_ratio, f"{void_ratio:g}, of the relative density {relative_density:g}: such spheres pack {found.in_words}"
