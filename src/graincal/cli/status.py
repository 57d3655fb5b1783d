"""graincal status."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from graincal.campaign.found.next_command import what_it_does
from graincal.cli.options import Folder
from graincal.cli.saying import say
from graincal.errors import InputError
from graincal.notation.printable import printable_json

_PERCENT = ("held-out error", "best ε", "ε_GL", "ε")
"""Figures of a round that are shown in percent."""

_ALWAYS = ("fits-about-as-well", "few-fit-about-as-well", "accepted-problems")
"""Beside doubts, what a person is told of a posterior's remarks: it holds while nothing else does yet."""


def status(
    folder: Folder,
    as_json: Annotated[bool, typer.Option("--json", help="For programs: every figure, as one JSON document.")] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Show it anew whenever it changes, until the campaign ends.")] = False,
) -> None:
    """Say how far a campaign is, also while it runs elsewhere."""
    from graincal.campaign.found.status import status as read_status

    if watch and as_json:
        raise InputError("--watch is for people and --json for programs: one of them was expected.")
    if watch:
        from graincal.cli.status_watch import watch_status

        watch_status(Path(folder), _lines)
        return
    found = read_status(Path(folder))
    say(printable_json(found, indent=2) if as_json else "\n".join(_lines(found)), prose=not as_json)


def _lines(status: dict[str, Any]) -> list[str]:
    from graincal.campaign.asked.calibration import round_of
    from graincal.campaign.found.to_end import ToEnd
    from graincal.notation.text import duration, sparkline

    lines = [f"{status['folder']}: {status['state']}, {status['method']}, {', '.join(status['experiments'])}"]
    lines.append(f"{status['evaluations']} evaluations, {status['failures']} failed{_stopped(status['stopped'])}, {duration(status['seconds'])} of run time")
    if (look := status["first_look"]) and look["state"] != "finished":
        lines += ["first look, before it:", *("  " + line for line in _lines(look))]
    elif look:
        lines.append(f"began with a first look: {look['folder']}, {look['evaluations']} evaluations")
    round_ = round_of(status["method"])
    if status["state"] != "finished" and (current := status["iteration"]):
        left = f", about {duration(status['seconds_left'])} left in it" if status["seconds_left"] else ""
        left += f", {ToEnd(**status['seconds_to_end'])}" if status["seconds_to_end"] else ""
        lines.append(
            f"{round_} {current['index']}: {current['evaluated']} of {current['samples']} evaluated, {current['failed']} failed{_stopped(current['stopped'])}{left}"
        )
    if status["iterations"]:
        last = status["iterations"][-1]
        of_paper = {"s": "s", "ESS": "effective_sample_size", "ε_GL": "gl_error", "ε": "error"}
        of_posterior = {"doubt": "doubt", "held-out error": "held_out_error", "log evidence": "log_evidence", "best ε": "best_error"}
        figures = [(name, last[key]) for name, key in (of_posterior if "posterior_shift" in last else of_paper).items()]
        lines.append(f"after {round_} {last['index']}: " + ", ".join(f"{name} {_figure(name, value)}" for name, value in figures))
        errors = [float("nan") if each["error"] is None else each["error"] for each in status["iterations"]]
        lines += [] if "posterior_shift" in last else [f"ε by iteration  {sparkline(errors, low=0.0)}"]
    if answer := status["answer"]:
        theta = _values(status, answer["theta"])
        spread = "" if answer["spread"] is None else f" ± {answer['spread']:.2f}"
        lines.append(f"answer: {theta}" + ("" if answer["mean"] is None else f"; its runs have ε {answer['mean']:.2f}{spread} %"))
    if posterior := status["posterior"]:
        lines.append(f"90 % interval{'' if status['settled'] else ' so far'}: {_intervals(status, posterior['interval_90'])}")
    for word in ("best", "most_probable") if status["method"] != "posterior" else ("best",):
        if candidate := status[word]:
            lines.append(f"{word.replace('_', ' ')}: ε {candidate['error']:.2f} % at {_values(status, candidate['theta'])}")
    for each in status.get("recorded", ()):
        error = "-" if each["mean"] is None else f"{each['mean']:.2f} %"
        lines.append(f"not fitted: {each['observable']} in {each['experiment']}, error {error} ({each['of']})")
    lines += [each["text"] for each in status["remarks"] if each["code"] in _ALWAYS or (each["level"] == "doubt" and each["code"] != "preliminary")]
    if status["stopped_by"]:
        lines.append(f"stopped by {status['stopped_by']}: {status['stopped_because']}")
        lines += [f"{what_it_does(status['stopped_by'])}: {status['next_command']}"] if status["next_command"] else []
    elif status["state"] == "waiting":
        folder = shlex.quote(status["folder"])
        lines += [f"{status['by_hand']} runs wait to be made by hand. To see which, and to hand in what they gave:"]
        lines += [f"  graincal ask {folder}", f"  graincal tell {folder} FOLDER"]
    elif status["state"] == "interrupted":
        lines.append(f"{what_it_does(None)}: {status['next_command']}")
    return lines


def _values(status: dict[str, Any], theta: dict[str, float]) -> str:
    """The values of the parameters with their units, and what they are the logarithms of."""
    from graincal.notation.markup import to_plain
    from graincal.notation.quantities import parameter

    shown = [(parameter(name, status["units"][name]), value) for name, value in theta.items()]
    return to_plain(", ".join(f"{each.label} {value:.4g}{each.behind}{each.without_log(value)}" for each, value in shown))


def _intervals(status: dict[str, Any], intervals: dict[str, list[float]]) -> str:
    """The ends of the parameters' intervals, with their units."""
    from graincal.notation.markup import to_plain
    from graincal.notation.numbers import between
    from graincal.notation.quantities import parameter

    shown = [(parameter(name, status["units"][name]), ends) for name, ends in intervals.items()]
    return to_plain(", ".join(f"{each.label} {between(*ends)}{each.behind}{each.without_log(*ends)}" for each, ends in shown))


def _figure(name: str, value: float | None) -> str:
    """A figure of the last round, with its unit; of the held-out error a part is known."""
    if value is None:
        return "-"
    return f"{100 * value if name == 'held-out error' else value:.3g}{' %' if name in _PERCENT else ''}"


def _stopped(count: int) -> str:
    return f", {count} stopped early" if count else ""
