"""What a proposed calibration file says of a simulator of the user's own: which parameters it takes, how it is run and what it writes are questions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from enum import Enum

from graincal.laboratory.decisions import UNANSWERED
from graincal.laboratory.quantities import STRAINS
from graincal.laboratory.understanding import Understanding

_FIRST = "parameter_1"
_ASKED = f'"{UNANSWERED}"'

PARAMETERS = "\n".join(
    [
        "[parameters]   # the unknowns and the ranges they are looked for in",
        "# Which parameters does your simulation take, and from where to where are they looked for? One line for each, by a name of yours: phi = { range = [15, 45], unit = 'deg' }",
        f"{_FIRST} = {{ range = {_ASKED} }}",
    ]
)

PRESSURE_QUESTION = (
    "# What is the confining pressure, as an effective stress in Pa? Take this line out where no stress ratio is computed from stresses of the file."
)

RUN_TIME = "# About the seconds that one run takes. Many cheap runs fill the ranges before anything is learnt:\n# expected_seconds = 2"


class OwnSimulator(str, Enum):
    """The kinds of [experiment.model] that are not graincal's own engine."""

    python = "python"
    command = "command"
    yade = "yade"
    by_hand = "by-hand"

    def model(self, control: str, observables: Iterable[str]) -> str:
        """The table of the model, for a control and observables."""
        quantities = [control, *observables]
        lines = {
            OwnSimulator.python: _function(quantities),
            OwnSimulator.command: [*_COMMAND, *_LIMIT, *_output(quantities, _FILE)],
            OwnSimulator.yade: [*_SCRIPT, *_LIMIT, *_output(quantities, _FILE)],
            OwnSimulator.by_hand: _output(quantities, []),
        }
        return "\n".join(["[experiment.model]", f'kind       = "{self.value}"', *lines[self]])


def stresses(found: Understanding) -> list[str]:
    """The columns of stresses that are read."""
    return [name for name in found.columns if name.endswith("stress") or name == "pore_pressure"]


def needs_pressure(found: Understanding) -> bool:
    """Whether what is compared is computed from stresses of the file, and so with the confining pressure."""
    return bool(stresses(found))


def asked_without_the_engine(found: Understanding) -> Understanding:
    """What was understood, without the questions that only the engine's table of a model has."""
    of_the_engine = {"kind", "void_ratio"} if needs_pressure(found) else {"kind", "void_ratio", "confining_pressure"}
    return replace(found, questions=tuple(question for question in found.questions if question.key not in of_the_engine))


_COMMAND = [
    f"# How is a simulation started? A list of words, with the values of parameters: ['python3', 'simulate.py', '--phi', '{{{{ {_FIRST} }}}}'].",
    f"command    = {_ASKED}",
    "# The files beside this one that it needs:",
    '# link       = ["simulate.py"]',
]
_SCRIPT = [
    "# Which script, beside this file?",
    f"script     = {_ASKED}",
    f"# What does its readParamsFromTable read, as ['{_FIRST}']? Where it reads sys.argv, write arguments = ['{{{{ {_FIRST} }}}}'] in the place of this line.",
    f"table      = {_ASKED}",
]
_LIMIT = ["# The seconds after which a run is ended:", "# time_limit = 3600"]
_FILE = ["# Which file does it write?", f"file       = {_ASKED}"]


def _function(quantities: list[str]) -> list[str]:
    return [
        f"# Which function, as 'module:name' of a file beside this one? It takes the values of the parameters in one array, and returns a dict of {' and '.join(quantities[1:])}:",
        "# strains as logarithmic fractions, stresses in Pa, compression and shortening positive; one value for each row of the reference.",
        f"function   = {_ASKED}",
        f"# Where it has values of {quantities[0]} of its own, these are:",
        "# control    = [0, 0.001, 0.002]",
    ]


def _output(quantities: list[str], file: list[str]) -> list[str]:
    """file: the lines of what the output is called."""
    strains = [name for name in quantities if name in STRAINS]
    return [
        "",
        "[experiment.model.output]",
        *file,
        *(["# How does it give strains: engineering or logarithmic?", f"strain     = {_ASKED}"] if strains else []),
        "# Which of its columns is this, by header or number? An expression of headers is one too, such as '1 + q / 100e3'.",
        f"columns    = {{ {', '.join(f'{name} = {_ASKED}' for name in quantities)} }}",
        "# { column = 'ezz', unit = '%', sign = -1 } says a unit and turns the sign: compression and shortening are positive.",
    ]
