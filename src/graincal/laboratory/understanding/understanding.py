"""What a laboratory file is of, as far as it proves it: the test, its columns, units, signs and measures; and what has to be asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np

from graincal.errors import InputError
from graincal.laboratory.backbone import repeated, spans, turned_back
from graincal.laboratory.columns import Place
from graincal.laboratory.decisions import UNANSWERED, Decision, Question
from graincal.laboratory.quantities import OF_CAMBRIDGE_AND_MIT, STRAINS, STRESS_FORMS
from graincal.laboratory.stages import choose_rows
from graincal.laboratory.table import Table, read_table
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.case import Case, Known, NotUnderstood, extent, extreme
from graincal.laboratory.understanding.compared import chosen_columns, observables_of
from graincal.laboratory.understanding.kinds import decide_kind
from graincal.laboratory.understanding.measures import decide_measures
from graincal.laboratory.understanding.pressure import decide_pressure, decide_turns
from graincal.laboratory.understanding.recorder import decide_axes
from graincal.laboratory.understanding.seen import Seen, see
from graincal.laboratory.understanding.signs import WORDS, decide_signs
from graincal.laboratory.understanding.staging import refuse_hidden_stages, refuse_other_zero, refuse_restarts, shear_stage
from graincal.laboratory.understanding.strains import void_ratio_of
from graincal.laboratory.understanding.stress_state import StressState, decide, stress_states
from graincal.laboratory.understanding.units import decide_height, decide_strains, decide_stresses, decide_void_ratio, decide_volume
from graincal.laboratory.understanding.volume import volume_changes

SHEAR = ("triaxial", "undrained", "constant-mean-stress")


@dataclass(frozen=True, eq=False)
class Understanding:
    """What a laboratory file is understood as.

    columns, units, compression, strain, zero and what follows are the keys of a calibration file, with "?" where a question is open; `questions` has what is likely
    for each. confining_pressure in Pa, None where nothing says it. lateral_is_known: whether the columns give the effective lateral stress of each row. loops and standstills: first and last lines where the control turns back or stands still.
    """

    table: Table
    seen: tuple[Seen, ...]
    kind: str
    control: str
    observables: tuple[str, ...]
    columns: Mapping[str, Place]
    units: Mapping[str, str]
    compression: Mapping[str, str]
    strain: Mapping[str, str]
    confining_pressure: float | None
    lateral_is_known: bool
    void_ratio: float | None
    turns: tuple[float, ...]
    sample_volume: float | None
    sample_height: float | None
    stage: str | None
    known: Known
    loops: tuple[tuple[int, int], ...]
    standstills: tuple[tuple[int, int], ...]
    decided: tuple[Decision, ...]
    questions: tuple[Question, ...]
    notes: tuple[str, ...]

    def proposed(self, key: str) -> str:
        """What is likely as the answer to a question; empty without one."""
        return next((question.proposed for question in self.questions if question.key == key), "")

    @property
    def zero(self) -> tuple[str, ...]:
        """What is counted from the first row that is read: strains of a part of the file's rows."""
        part = self.stage is not None or self.known.rows is not None
        return tuple(name for name in self.columns if name in (*STRAINS, "volume_change", "axial_displacement")) if part else ()


def understand(path: str | PathLike[str], known: Known = Known()) -> Understanding:
    """Look at a laboratory file. Raises InputError where it cannot be read as a table, where a unit is stated and not known, where stages cannot be told apart, where
    the columns contradict one another or allow more than one stress state, and where no test can be made of them."""
    case, stage = _case(path, known)
    decide_axes(case)
    decide_void_ratio(case)
    decide_strains(case)
    decide_stresses(case)
    volume = decide_volume(case)
    decide_height(case)
    _decide_state(case)
    if stage is None:
        _refuse_stages(case)
    _refuse_strange(case)
    decide_kind(case)
    decide_signs(case)
    control, observables = observables_of(case)
    _refuse_without_stress(case, observables)
    if known.stage is None and known.rows is None and stage is None and case.kind in SHEAR:
        refuse_other_zero(case)
    columns = chosen_columns(case, control, observables)
    decide_measures(case, tuple(name for name in columns if name in STRAINS))
    pressure, turns = decide_pressure(case), decide_turns(case, control)
    loops, standstills = _turns(case, control)
    return Understanding(
        table=case.table,
        seen=tuple(case.columns),
        kind=UNANSWERED if any(question.key == "kind" for question in case.questions) else case.kind,
        control=control,
        observables=observables,
        columns={name: [each.place for each in column] if isinstance(column, tuple) else column.place for name, column in columns.items()},
        units=_units(case, columns),
        compression=_compression(case, columns),
        strain=dict(case.measures),
        confining_pressure=pressure,
        lateral_is_known=case.state is not None and case.state.lateral is not None,
        void_ratio=known.void_ratio if known.void_ratio is not None else _void_ratio(case),
        turns=turns,
        sample_volume=volume if "volume_change" in columns else None,
        sample_height=case.sample_height if "axial_displacement" in columns else None,
        stage=stage,
        known=known,
        loops=loops,
        standstills=standstills,
        decided=tuple(case.decided),
        questions=tuple(case.questions),
        notes=tuple(case.notes),
    )


def _case(path: str | PathLike[str], known: Known) -> tuple[Case, str | None]:
    """The rows that are looked at, and the stage that they are of."""
    table = read_table(path, encoding=known.encoding, sheet=known.sheet)
    stage = None if known.stage is None else str(known.stage)
    decided: list[Decision] = []
    if known.stage is not None or known.rows is not None:
        table, _ = choose_rows(table, known.stage, known.rows)
    else:
        table, stage, decided = shear_stage(table, known)
    case = Case(table, known, (*table.remarks, *table.header), see(table, known.columns))
    case.decided += [*table.decided, *decided]
    # How names are encoded is nothing to ask where there is none, or none that it changes.
    shown = not all(name.isascii() for name in table.header)
    case.questions += [question for question in table.questions if question.key != "columns" and (question.key != "encoding" or shown)]
    return case, stage


def _decide_state(case: Case) -> None:
    """The stress state of each row, from all columns of stresses."""
    stresses = [column for column in case.columns if column.quantity in STRESS_FORMS]
    if (back := case.column("back_pressure")) is not None and case.column("pore_pressure") is None and volume_changes(case):
        # Drained, the pore pressure is the back pressure.
        stresses.append(replace(back, meaning=replace(back.meaning, quantity="pore_pressure")))
    if not stresses:
        return
    states, reasons = stress_states(
        _as_said_in_words(case, stresses), case.wet, {name: 1.0 if sign == "positive" else -1.0 for name, sign in case.known.compression.items()}
    )
    if not states:
        names = ", ".join(
            f"{column.label} ({column.quantity}{f', without a unit and taken in {column.unit.symbol}' if column.unit and column.index in case.bare_stresses else ''})"
            for column in stresses
        )
        raise InputError(
            f"{case.table.path}: the stresses of columns {names} can be those of no test: {', and otherwise '.join(reasons)}. --column QUANTITY=COLUMN:UNIT says what each is."
        )
    chosen, possible = decide(states)
    if chosen is None:
        chosen = _by_sign(case, possible)
    if chosen is None:
        ways = " or ".join(_in_words(case, state) for state in possible[:3])
        raise InputError(
            f"{case.table.path}: the columns of stresses can be {ways}, and nothing in the file decides it: say which by --column, such as --column mean_stress=COLUMN "
            "or --column half_sum_stress=COLUMN for p, --column deviator_stress=COLUMN or --column half_difference_stress=COLUMN for q, --column total_lateral_stress=COLUMN."
        )
    case.state = chosen
    meant = {index: name for index, (name, _) in chosen.quantities.items()}
    for column in stresses:
        if column.index in meant and column.quantity != "back_pressure":
            case.replace(replace(column, meaning=replace(column.meaning, quantity=meant[column.index])) if column.quantity != meant[column.index] else column)
    if chosen.because:
        case.decide("stresses", _in_words(case, chosen), chosen.because)


def _as_said_in_words(case: Case, stresses: list[Seen]) -> list[Seen]:
    """The columns of stresses, where p and q are what the file says that they are."""
    if not remarks.of_mit(case.words):
        return stresses
    return [
        replace(column, meaning=replace(column.meaning, quantity=OF_CAMBRIDGE_AND_MIT[column.quantity], symbol=False))
        if column.meaning.symbol and not column.said and column.quantity in OF_CAMBRIDGE_AND_MIT
        else column
        for column in stresses
    ]


def _by_sign(case: Case, possible: list[StressState]) -> StressState | None:
    """Of states that differ by the sign of a deviator stress alone, the one whose axial strain has the sign that the normal stresses have."""
    strain = case.column("axial_strain")
    if strain is None or len({tuple(name for name, _ in state.quantities.values()) for state in possible}) > 1:
        return None
    fits = []
    for state in possible:
        normal = next((sign for name, sign in state.quantities.values() if name not in ("deviator_stress", "half_difference_stress", "pore_pressure")), None)
        if normal is None or state.deviator is None:
            return None
        if extreme(strain.values) * normal * extreme(state.deviator) > 0:
            fits.append(state)
    return replace(fits[0], because=f"{strain.label} then has the sign of the normal stresses") if len(fits) == 1 else None


def _in_words(case: Case, state: StressState) -> str:
    headers = {column.index: column.label for column in case.columns}
    return ", ".join(f"{headers[index]} as {name}{' with its sign turned' * (sign < 0)}" for index, (name, sign) in state.quantities.items())


def _refuse_stages(case: Case) -> None:
    state = case.state
    if state is None or case.column("axial_strain") is None:
        return
    total = state.lateral if state.lateral is None or state.pore is None else state.lateral + state.pore
    for lateral in (total, state.lateral if not _pore_moves(case) else None):
        refuse_hidden_stages(case.table, case.columns, lateral, state.deviator, state.lateral)


def _pore_moves(case: Case) -> bool:
    pore = case.column("pore_pressure") or case.column("excess_pore_pressure")
    return pore is not None and extent(pore.plain) > 0


def _refuse_strange(case: Case) -> None:
    """Refuse a file of which no test can be made: nothing to drive it by, or nothing to compare."""
    driven = (
        [case.shortening]
        if case.shortening is not None
        else (["stress"] if case.void_ratio and (case.column("axial_stress") or case.column("mean_stress")) else [])
    )
    compared = (
        case.state is not None
        or any(case.column(name) for name in ("stress_ratio", "deviator_to_mean_stress", "volumetric_strain", "volume_change", "excess_pore_pressure"))
        or case.summed
    )
    if driven and (compared or case.void_ratio):
        return
    reasons = [f"{column.label} would be {column.unusable}" for column in case.columns if column.unusable]
    listed = ", ".join(f"{column.index + 1} {case.table.label(column.index)}" if column.header else str(column.index + 1) for column in case.columns)
    lacking = "an axial strain" if compared else "a stress or a volumetric strain" if driven else "an axial strain, a stress or a volumetric strain"
    raise NotUnderstood(
        f"{case.table.path}: none of the columns {listed} is known as {lacking}{' (' + '; '.join(reasons) + ')' if reasons else ''}: --column axial_strain=COLUMN:UNIT and so on say which is which, "
        "by numbers or names."
    )


def _refuse_without_stress(case: Case, observables: tuple[str, ...]) -> None:
    """Refuse to compare a sheared sample by its volume alone where a column that is not understood may be a stress, unless a person names columns."""
    unknown = [column for column in case.columns if column.has_numbers and not column.quantity and column.meaning.quantity not in ("stage", "time")]
    if case.kind not in SHEAR or {"stress_ratio", "deviatoric_stress"} & set(observables) or not unknown or case.known.columns:
        return
    listed = ", ".join(f"{column.index + 1} {column.label}{f' ({column.unusable})' * bool(column.unusable)}" for column in unknown)
    raise InputError(
        f"{case.table.path}: no column is known as a stress, and the test would be compared by {' and '.join(observables).replace('_', ' ') or 'nothing'} alone, while it is not known what {listed} {'is' if len(unknown) == 1 else 'are'}: "
        "--column deviator_stress=COLUMN:UNIT, or stress_ratio, axial_stress and so on, says which is; --column axial_strain=COLUMN:UNIT alone that none is."
    )


def _turns(case: Case, control: str) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]:
    column = case.shortening
    if column is None or control not in ("axial_strain", "axial_extension"):
        return (), ()
    there = ~np.isnan(column.values)
    strain = column.values[there] * case.strain_sign.get(column.quantity, 1.0) * (-1.0 if case.extension else 1.0)
    lines = [line for line, kept in zip(case.table.lines, there, strict=True) if kept]
    refuse_restarts(case.table.path, strain, lines)
    return tuple(spans(turned_back(strain), lines)), tuple(spans(repeated(strain), lines))


def _units(case: Case, columns: Mapping[str, Seen | tuple[Seen, ...]]) -> dict[str, str]:
    asked = {question.key for question in case.questions}
    first = {name: column[0] if isinstance(column, tuple) else column for name, column in columns.items()}
    return {
        name: UNANSWERED if f"units.{name}" in asked or column.index in case.bare_stresses else column.unit.symbol
        for name, column in first.items()
        if column.unit is not None
    }


def _compression(case: Case, columns: Mapping[str, Seen | tuple[Seen, ...]]) -> dict[str, str]:
    asked = {question.key for question in case.questions}
    found = {}
    for name, column in columns.items():
        each = column[0] if isinstance(column, tuple) else column
        if f"compression.{name}" in asked:
            found[name] = UNANSWERED
        elif name in STRAINS or name in ("volume_change", "axial_displacement"):
            sign = case.strain_sign.get(name, case.strain_sign.get("axial_strain", 1.0))
            found[name] = WORDS[sign]
        elif case.state is not None and each.index in case.state.quantities and name != "pore_pressure":
            found[name] = WORDS[case.state.quantities[each.index][1]]
    return found


def _void_ratio(case: Case) -> float | None:
    """Of the sample where its test begins: what its column begins with, else what a line says, else what a column of initial void ratios begins with; None for several that differ."""
    initial = _first_void_ratio(case.column("initial_void_ratio"))
    if case.kind in ("oedometric", "isotropic") and initial is not None:
        return initial  # before the first load
    first, said = _first_void_ratio(case.void_ratio), remarks.void_ratios(case.table.remarks)
    if first is not None and case.void_ratio is not None:
        case.decide("void_ratio", f"{first:g}", f"{case.void_ratio.label} begins so")
        return first
    if len(said) > 1:
        case.notes.append(f"The file says void ratios of {', '.join(f'{value:g}' for value in said)}, and which of them is the sample's is not known.")
        return None
    if said:
        case.decide("void_ratio", f"{said[0]:g}", "a line above the table says so", by="words")
        return said[0]
    return initial


def _first_void_ratio(column: Seen | None) -> float | None:
    if column is None:
        return None
    values = column.values[~np.isnan(column.values)]
    found = void_ratio_of("void_ratio" if column.quantity == "initial_void_ratio" else column.quantity, values) if values.size else None
    return None if found is None else round(float(found[0]), 6)
