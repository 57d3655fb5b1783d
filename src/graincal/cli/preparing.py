"""The packing that graincal init has prepared: of which particles, and at which void ratio."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graincal.cli.saying import say
from graincal.data import InputError

if TYPE_CHECKING:
    from graincal.campaign.file.propose import Preparation
    from graincal.dem.preparation import Reach

SEED = 1
LOOSE = 0.15
"""The relative density up to which spheres are said to be about the loosest."""


def check_alone(packing: Path | None, void_ratio: float | None, relative_density: float | None, grading: str | None, particles: int | None) -> None:
    """Raise InputError for options that cannot stand beside one another, and for a relative density beyond its ends."""
    if relative_density is not None:
        check_relative_density(relative_density)
    said = {"--void-ratio": void_ratio, "--relative-density": relative_density, "--grading": grading, "--particles": particles}
    given = [option for option, value in said.items() if value is not None]
    if packing and given:
        own = {"--void-ratio": "a void ratio", "--relative-density": "a void ratio"}.get(given[0], "grains")
        raise InputError(f"--packing has {own} of its own, so {given[0]} cannot stand beside it.")
    if void_ratio is not None and relative_density is not None:
        raise InputError("--relative-density gives the void ratio, so --void-ratio cannot stand beside it.")


def check_relative_density(relative_density: float) -> None:
    """Raise InputError for one beyond its ends."""
    if not 0 <= relative_density <= 1:
        meant = f"; if {relative_density:g} % is meant, write {relative_density / 100:g}" if 1 < relative_density <= 100 else ""
        raise InputError(f"--relative-density must be from 0, the loosest packing, to 1, the densest, not {relative_density:g}{meant}.")


def asked_preparation(relative_density: float | None, grading: str | None, particles: int | None) -> Preparation:
    """The packing to prepare; at a relative density, with its void ratio. Raises InputError for a grading that cannot be read, and where its reach cannot be found."""
    from graincal.campaign.file.propose import Preparation
    from graincal.dem.grading import Grading

    particles = Preparation.particles if particles is None else particles
    grading = Preparation.grading if grading is None else grading
    Grading.named(grading)
    is_file = Path(grading).exists()
    if relative_density is None:
        return Preparation(particles, grading, grading_is_file=is_file)
    found = reach_of(particles, grading)
    void_ratio = round(found.void_ratio(relative_density), 4)
    because = (
        f"The void ratio: {void_ratio:g} is that of the relative density {relative_density:g} that you gave, for spheres of grading {grading}.",
        f"{_found(found, particles)} A sand of the same relative density has a void ratio of its own, so what is compared is how much the volume changes.",
    )
    return Preparation(particles, grading, void_ratio, because, is_file)


def out_of_reach(void_ratio: float, preparation: Preparation) -> str:
    """What is said of a void ratio that the grading does not pack to or is about its loosest, or whose grains are too few; empty for others."""
    try:
        found = reach_of(preparation.particles, preparation.grading)
    except InputError as error:
        return f"Note: {error}"
    if found.holds(void_ratio):
        return said_of_loose(found, void_ratio)
    way = "looser" if void_ratio > found.loosest else "denser"
    return (
        f"Note: the void ratio of {void_ratio:g} is {way} than spheres of grading {preparation.grading} pack. {_found(found, preparation.particles)} "
        f"{'Real grains are no spheres, and pack looser. ' if way == 'looser' else ''}What people compare then is a packing of the same relative density, "
        "(e_max - e)/(e_max - e_min): --relative-density VALUE, from 0 to 1, gives its void ratio."
    )


def said_of_loose(found: Reach, void_ratio: float) -> str:
    """What is said of a void ratio that is about the loosest of spheres, as that of many a dense sand is; empty for others."""
    density = found.relative_density(void_ratio)
    if density > LOOSE:
        return ""
    return (
        f"Note: a void ratio of {void_ratio:g} is a relative density of {100 * max(density, 0.0):.0f} % for these spheres, about the loosest: they pack {found.in_words}. Real grains are no spheres, and pack looser. "
        "Where your sand is denser than that, --relative-density VALUE of graincal init, from 0 to 1, gives spheres of the same density."
    )


def _found(reach: Reach, particles: int) -> str:
    """The reach in a sentence, with how it was found."""
    about = "" if reach.particles == particles else f", of which the range of {particles} is about that"
    return f"They pack {reach.in_words}: found by packing {reach.particles} of them with the friction angle of 45° and without friction{about}."


def reach_of(particles: int, grading: str, *, quiet: bool = False) -> Reach:
    """The void ratios that a grading packs to, which is said where it may take some seconds."""
    from graincal.dem.preparation import reach

    if not quiet:
        say(f"Looking up what void ratios grading {grading} packs to, the first time some seconds ...", err=True)
    return reach(particles, grading, SEED)
