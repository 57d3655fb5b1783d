"""What is to be said of a prior beside its ranges."""

from __future__ import annotations

from graincal.data import ParameterSpace
from graincal.notation.words import listed
from graincal.parameter_space import LOG


def beside_ranges(space: ParameterSpace) -> list[str]:
    """Sentences on parameters that are fixed, those whose prior is uniform in the logarithm, and what constraints leave; none mostly. Names are those of the file."""
    said = []
    if space.fixed:
        said.append(f"Fixed: {', '.join(f'{name} = {value:g} {space.units_of_fixed[name]}'.rstrip() for name, value in space.fixed.items())}.")
    if logarithmic := [name for name, scale in zip(space.names, space.scales) if scale == LOG]:
        said.append(f"The prior of {listed(logarithmic)} is uniform in the logarithm.")
    if space.constraints:
        sources = list(dict.fromkeys(constraint.source for constraint in space.constraints))
        each = " in each experiment" if len(sources) < len(space.constraints) else ""
        said.append(f"The prior is uniform where {listed(sources)}{each}, which is {100 * space.part:.3g} % of the ranges.")
    return said
