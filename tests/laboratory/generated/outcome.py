"""A file is given to `graincal init` and `graincal check`, and what they say is compared with what is right.

RIGHT: read, and every figure is right. ASKED: refused in a sentence, or `check` has a question or a problem. LACKING: right as far as it goes, but an observable
is missing. ASTRAY: asked or refused, and not about what is undecided. WRONG: passed in silence, and a figure or the kind is not right. BROKEN: neither of the commands keeps to what they promise.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

from typer.testing import CliRunner, Result

from graincal.cli import app
from graincal.data import InputError

from .expectation import Expectation


@dataclass(frozen=True)
class Outcome:
    verdict: str
    why: str
    said: dict[str, Any] = field(default_factory=dict)
    """What `check --json` printed."""


# What a calibration will cost is another matter, and takes a short simulation.
def _invoke(*arguments: str) -> Result:
    with patch("graincal.campaign.file.expectation.expect", return_value=[]):
        return CliRunner().invoke(app, list(arguments))


def read(file: Path, options: list[str], packing: Path, calibration: Path, expected: Expectation | None, asked: str = "") -> Outcome:
    """Run both commands; without an expectation anything that passes in silence is WRONG. asked: a regular expression of what is to be asked about."""
    found = _read(file, options, packing, calibration, expected)
    return replace(found, verdict="ASTRAY") if found.verdict == "ASKED" and not re.search(asked, found.why) else found


def _read(file: Path, options: list[str], packing: Path, calibration: Path, expected: Expectation | None) -> Outcome:
    calibration.unlink(missing_ok=True)
    result = _invoke("init", str(file), "--packing", str(packing), "-o", str(calibration), *options)
    if (refused := _refusal(result)) is not None:
        return _sentence("init", refused)
    if result.exit_code != 0 or not calibration.exists():
        return Outcome("BROKEN", f"init: {_trouble(result)}")
    return checked(calibration, expected)


def checked(calibration: Path, expected: Expectation | None) -> Outcome:
    """`graincal check --json` of a calibration file."""
    result = _invoke("check", str(calibration), "--json")
    if (refused := _refusal(result)) is not None:
        return _sentence("check", refused)
    try:
        said = json.loads(result.stdout)
        experiments, asked = said["experiments"], [*map(text_of, said["questions"]), *map(text_of, said["problems"])]
    except (ValueError, KeyError, TypeError):
        return Outcome("BROKEN", f"check: {_trouble(result)}")
    if result.exit_code == 2:
        return Outcome("ASKED", " | ".join(asked), said) if asked else Outcome("BROKEN", "check: exit 2 without a question or a problem", said)
    if result.exit_code != 0 or asked or len(experiments) != 1:
        return Outcome("BROKEN", f"check: exit {result.exit_code}, {len(experiments)} experiments, asked {asked}", said)
    if expected is None:
        return Outcome("WRONG", f"passed in silence: {_short(experiments[0])}", said)
    return _compared(experiments[0], expected, calibration, said)


def _compared(experiment: dict[str, Any], expected: Expectation, calibration: Path, said: dict[str, Any]) -> Outcome:
    try:
        wrong = differences(experiment, expected, calibration)
    except (KeyError, TypeError, AttributeError) as error:
        return Outcome("BROKEN", f"check: {error!r} in {_short(experiment)}", said)
    if wrong:
        return Outcome("WRONG", "; ".join(wrong), said)
    lacking = [name for name in expected.required if name not in experiment["observables"]]
    return Outcome("LACKING", f"no {', '.join(lacking)}", said) if lacking else Outcome("RIGHT", "", said)


def differences(experiment: dict[str, Any], expected: Expectation, calibration: Path | None) -> list[str]:
    """All that is not as expected; a missing observable is not among it."""
    wrong: list[str] = []
    if experiment["kind"] != expected.kind:
        wrong.append(f"kind is {experiment['kind']}, not {expected.kind}")
    pressure = expected.confining_pressure
    if pressure is not None and not abs((experiment["confining_pressure"] or 0) - pressure) <= 0.005 * pressure:
        wrong.append(f"confining_pressure is {experiment['confining_pressure']}, not {pressure:g}")
    if expected.states is not None and experiment["states"] != expected.states:
        wrong.append(f"states are {experiment['states']}, not {expected.states}")
    if control_name(experiment) not in expected.control:
        wrong.append(f"control is {control_name(experiment)}, not {' or '.join(expected.control)}")
    elif expected.control_figures and (figures := control_figures(experiment, calibration)):
        wrong += expected.control_figures.differences(control_name(experiment), figures)
    for name, figures in {**expected.known, **expected.required}.items():
        if name in experiment["observables"]:
            wrong += figures.differences(name, experiment["observables"][name])
    return wrong


def control_name(experiment: dict[str, Any]) -> str:
    control = experiment["control"]
    return str(control["name"] if isinstance(control, dict) else control)


def control_figures(experiment: dict[str, Any], calibration: Path | None) -> dict[str, float] | None:
    """First and last of the control: in the JSON, or else as `graincal check` shows them to people."""
    name, control = control_name(experiment), experiment["control"]
    if isinstance(control, dict) and "last" in control:
        return control
    if "control_range" in experiment:
        return experiment["control_range"]
    if name in experiment["observables"]:
        return experiment["observables"][name]
    if calibration is None:
        return None
    shown = _invoke("check", str(calibration)).stdout
    found = re.search(rf"\b{name} (\S+) to (\S+?)[,.;]?\s", shown)
    if not found:
        raise KeyError(f"the range of {name} is not shown")
    first, last = float(found[1]), float(found[2])
    return {"first": first, "last": last, "min": min(first, last), "max": max(first, last)}


def _refusal(result: Result) -> str | None:
    """What a command said where it ended with 1."""
    if isinstance(result.exception, InputError):
        return str(result.exception)
    return result.stderr.strip() if result.exit_code == 1 and isinstance(result.exception, SystemExit) else None


def _sentence(command: str, said: str) -> Outcome:
    if not said or "Traceback" in said:
        return Outcome("BROKEN", f"{command}: refused without a sentence: {said[-300:]}")
    return Outcome("ASKED", f"{command} refuses: {said}")


def _trouble(result: Result) -> str:
    said = (result.stderr or result.stdout or "").strip()[-300:]
    return f"exit {result.exit_code}, {result.exception!r}: {said}"


def text_of(item: Any) -> str:
    return item if isinstance(item, str) else json.dumps(item, ensure_ascii=False)


def _short(experiment: Any) -> str:
    return json.dumps(experiment, ensure_ascii=False)[:400]
