"""A file before it is printed: its columns, what is said above them, and what `graincal init` is told; and how it is printed."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import numpy as np

from .choice import STRAINS, STRESSES, Choice
from .curves import COMPRESSION_LINES, DRAINED, Array, Truth, truth, with_stages
from .units import FRACTIONS, PRESSURES
from .words import LANGUAGES, words

DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "spaces": "   "}
STAGE_WORDS = ("Saturation", "Consolidation", "Shear")
STRAIN_QUANTITIES = ("axial_strain", "volumetric_strain", "radial_strain")
RATIO_DECIMALS = {"stress_ratio": 5, "deviator_to_mean_stress": 5, "void_ratio": 5, "porosity": 6}


@dataclass
class Column:
    """`values` are in the unit and the sign of the file. `factor`: what one of the unit is."""

    quantity: str
    name: str
    unit: str
    values: Array
    decimals: int
    factor: float = 1.0
    cells: str = "plain"

    @property
    def rounding(self) -> float:
        """Half of the last digit, in SI units."""
        return 0.5 * 10.0**-self.decimals * self.factor


@dataclass
class Draft:
    """What a file is made of; the remarks and the options by what they are about, so that one can be taken away."""

    choice: Choice
    test: Truth
    columns: list[Column]
    rng: random.Random
    remarks: dict[str, str] = field(default_factory=dict)
    options: dict[str, list[str]] = field(default_factory=dict)
    stages: list[int] = field(default_factory=list)
    """The stage of each row, where there are stages."""
    stage_column: bool = False

    @property
    def delimiter(self) -> str:
        return DELIMITERS[self.choice["delimiter"]]

    @property
    def rows(self) -> int:
        return len(self.columns[0].values)

    def column(self, quantity: str) -> Column:
        return next(column for column in self.columns if column.quantity == quantity)

    def drop(self, quantity: str) -> None:
        self.columns = [column for column in self.columns if column.quantity != quantity]

    def rounding(self, *quantities: str, default: float = 0.0) -> float:
        return max([column.rounding for column in self.columns if column.quantity in quantities], default=default)


# What is drafted.


def drafted(choice: Choice, rng: random.Random) -> Draft:
    """A file of these choices, with all that an expert needs to read it."""
    large = choice["cells"] == "thousands" and choice["family"] in DRAINED
    test = truth(choice["family"], rng, pressure=400e3 if large else None)
    whole, stages = with_stages(test, from_zero=choice["stages"] == "rows" or rng.random() < 0.3) if choice["stages"] != "none" else (test, [])
    vocabulary = words(choice["style"], test.extends, choice["family"] in COMPRESSION_LINES)
    quantities = [*STRAINS[choice["strain"]], *STRESSES[choice["stress"]]]
    if rng.random() < 0.3:
        rng.shuffle(quantities)
    columns = [_column(quantity, choice, whole, test, rng.choice(vocabulary[quantity]), rng) for quantity in quantities]
    draft = Draft(choice, test, columns, rng, stages=stages, stage_column=choice["stages"] in ("numbers", "words"))
    _signs(draft)
    _told(draft)
    if choice["time"] == "yes":
        draft.columns.insert(0, Column("time", "Time", "s", 30.0 * np.arange(len(whole.axial_strain)), 0))
    return draft


def _column(quantity: str, choice: Choice, whole: Truth, test: Truth, name: str, rng: random.Random) -> Column:
    values = whole.of(quantity)
    if quantity in STRAIN_QUANTITIES:
        if choice["measure"] == "engineering":
            values = 1 - np.exp(-values)
        unit = choice["strain unit"]
        decimals = {"%": 4, "permille": 3}.get(unit, 6)
        cells = "percent" if choice["cells"] == "percent" else "plain"
        in_header = unit if cells == "plain" or choice["style"] in ("row of units", "two lines") else ""
        return Column(quantity, name, in_header, values / FRACTIONS[unit], decimals, FRACTIONS[unit], cells)
    if quantity in RATIO_DECIMALS:
        return Column(quantity, name, rng.choice(["", "-"]), values, RATIO_DECIMALS[quantity])
    unit = choice["stress unit"]
    decimals = stress_decimals(test.pressure / PRESSURES[unit])
    thousands = choice["cells"] == "thousands"
    if thousands and decimals in (0, 3):
        decimals += 1
    return Column(quantity, name, unit, values / PRESSURES[unit], decimals, PRESSURES[unit], "thousands" if thousands else "plain")


def stress_decimals(pressure: float) -> int:
    """Five digits of the confining pressure."""
    return max(0, 4 - int(np.floor(np.log10(pressure))))


def _signs(draft: Draft) -> None:
    sign = draft.choice["sign"]
    invariant = draft.choice["stress"] == "p, q" and draft.choice["family"] in ("drained dense", "drained loose") and draft.rng.random() < 0.5
    for column in draft.columns:
        turned = {"all negative": column.quantity not in RATIO_DECIMALS, "dilation positive": column.quantity == "volumetric_strain"}.get(sign, False)
        if turned and not (invariant and column.quantity == "deviator_stress"):
            column.values = -column.values


KINDS = {
    "drained dense": ("drained triaxial compression test", "CD triaxial compression", "consolidated drained triaxial compression"),
    "drained loose": ("drained triaxial compression test", "CD triaxial compression", "consolidated drained triaxial compression"),
    "drained extension": ("drained triaxial extension test with constant lateral stress",),
    "undrained contractive": ("consolidated undrained triaxial compression test", "CU triaxial compression, undrained"),
    "undrained dilative": ("consolidated undrained triaxial compression test", "undrained triaxial compression"),
    "undrained extension": ("undrained triaxial extension test",),
    "constant mean stress": ("triaxial compression with constant mean effective stress", "drained triaxial compression with p' constant"),
    "oedometer": ("oedometer test", "oedometric compression test"),
    "isotropic cycle": ("isotropic compression test",),
    "isotropic one way": ("isotropic compression test",),
}
MEASURES = {
    "engineering": ("strains: engineering", "engineering strain", "strain measure: engineering"),
    "logarithmic": ("strains: logarithmic", "logarithmic strain", "true (logarithmic) strain"),
}


def _told(draft: Draft) -> None:
    """What the columns do not say, in a remark or an option."""
    choice, rng = draft.choice, draft.rng
    if rng.random() < 0.4:
        draft.remarks["sample"] = rng.choice(["Sample S-1, quartz sand", "Specimen A, clean sand"])
    if choice["kind from"] == "remark":
        draft.remarks["kind"] = rng.choice(KINDS[choice["family"]])
    elif choice["kind from"] == "option":
        draft.options["kind"] = ["--kind", draft.test.kind]
    if choice["pressure from"] == "remark":
        draft.remarks["pressure"] = (
            f"{rng.choice(['effective confining pressure:', 'effective confining pressure =', 'confining pressure'])} {draft.test.pressure / 1e3:.0f} kPa"
        )
    elif choice["pressure from"] == "option":
        draft.options["pressure"] = ["--confining-pressure", f"{draft.test.pressure:g}"]
    if choice["measure from"] == "remark":
        draft.remarks["measure"] = rng.choice(MEASURES[choice["measure"]])
    elif choice["measure from"] in ("option", "void ratio"):
        # The void ratio proves the measure of the volumetric strain alone: that of the axial one is said.
        draft.options["measure"] = ["--strain", choice["measure"]]
    if choice["sign"] == "dilation positive" and choice["sign from"] == "remark":
        draft.remarks["sign"] = rng.choice(["volumetric strain: dilation positive", "volumetric strain is positive in dilation"])
    if choice["encoding"] in ("cp1251", "gbk") and rng.random() < 0.5:
        draft.options["encoding"] = ["--encoding", choice["encoding"]]
    if choice["stages"] in ("numbers", "words"):
        draft.options["stage"] = ["--stage", "3" if choice["stages"] == "numbers" else rng.choice(["Shear", "shear"])]


# How it is printed.


def printed(draft: Draft) -> tuple[bytes, list[str]]:
    """The file, and the options of `graincal init`."""
    above = [*_remark_lines(draft), *_header_lines(draft)]
    body = [_line(cells, draft) for cells in zip(*_cells(draft), strict=True)]
    text = "\n".join([*above, *body]) + "\n"
    options = [word for option in draft.options.values() for word in option]
    if draft.choice["named"] == "yes":
        options += _column_options(draft)
    if draft.choice["stages"] == "rows":
        first = sum(line.count("\n") + 1 for line in above) + 1
        shear = [first + row for row, stage in enumerate(draft.stages) if stage == 3]
        options += ["--rows", f"{shear[0]}-{shear[-1]}"]
    end = draft.rng.choice(["\n", "\n", "\r\n"])
    return text.replace("\n", end).encode(draft.choice["encoding"]), options


def _remark_lines(draft: Draft) -> list[str]:
    remarks = list(draft.remarks.values())
    marked = draft.choice["delimiter"] == "spaces" or draft.choice["style"] in ("none", "in a comment") or draft.rng.random() < 0.6
    if draft.choice["encoding"] == "cp1252" and draft.choice["style"] not in LANGUAGES:
        remarks.insert(0, "Temperature 20 °C")
    return [f"# {remark}" for remark in remarks] if marked else [remark.replace(",", "") for remark in remarks]


def unit_in_words(unit: str, draft: Draft) -> str:
    """One of the ways to write a unit, for all of the file."""
    if draft.rng.random() < 0.4:
        return unit
    if draft.choice["style"] == "Russian" and unit in ("kPa", "MPa", "Pa"):
        return unit.replace("Pa", "Па").replace("k", "к").replace("M", "М")
    if unit == "permille":
        return "‰"
    return unit.replace("2", "²") if draft.choice["encoding"].startswith("utf") else unit


def _header_lines(draft: Draft) -> list[str]:
    style, rng = draft.choice["style"], draft.rng
    written = {unit: unit_in_words(unit, draft) for unit in dict.fromkeys(column.unit for column in draft.columns)}
    units = [written[column.unit] for column in draft.columns]
    names = [column.name for column in draft.columns]
    brackets = "[]"
    if style == "name (unit)" or (style in ("symbols", "letters", *LANGUAGES) and rng.random() < 0.5):
        brackets = "()"
    in_brackets = [f"{brackets[0]}{unit}{brackets[1]}" if unit else "" for unit in units]
    if style == "none":
        return []
    if style == "row of units":
        shown = [unit or "[-]" for unit in in_brackets] if rng.random() < 0.5 else [unit or "-" for unit in units]
        return [_line(_with_stage(draft, "Stage", names), draft), _line(_with_stage(draft, "-", shown), draft)]
    if style == "two lines":
        return _two_lines(draft, names, units)
    if style == "name, unit":
        joined = [
            f"{name}, {'fraction' if unit == '-' and column.quantity in STRAIN_QUANTITIES else unit}".removesuffix(", ")
            for name, unit, column in zip(names, units, draft.columns)
        ]
    else:
        joined = [f"{name} {unit}".strip() for name, unit in zip(names, in_brackets)]
    line = _line(_with_stage(draft, "Stage", joined), draft)
    return [f"# {line}" if style == "in a comment" else line]


def _two_lines(draft: Draft, names: list[str], units: list[str]) -> list[str]:
    """A name and its unit one below the other: two lines of the file, or two lines within a cell."""
    if draft.choice["delimiter"] in ("comma", "semicolon") and draft.rng.random() < 0.5:
        cells = [f"{name}\n[{unit}]" if unit else name for name, unit in zip(names, units)]
        return [_line(cells, draft)]
    parts = [(*name.rsplit(" ", 1), f"[{unit or '-'}]") if " " in name else (name, "", f"[{unit or '-'}]") for name, unit in zip(names, units)]
    first = [part[0] for part in parts]
    second = [f"{part[1]} {part[2]}".strip() for part in parts]
    return [_line(first, draft), _line(second, draft)]


def _with_stage(draft: Draft, cell: str, cells: list[str]) -> list[str]:
    return [cell, *cells] if draft.stage_column else cells


def _cells(draft: Draft) -> list[list[str]]:
    columns = [[number(value, column, draft.choice["decimal"]) for value in column.values] for column in draft.columns]
    if not draft.stage_column:
        return columns
    return [[str(stage) if draft.choice["stages"] == "numbers" else STAGE_WORDS[stage - 1] for stage in draft.stages], *columns]


def number(value: float, column: Column, decimal: str) -> str:
    text = f"{value:{',' if column.cells == 'thousands' else ''}.{column.decimals}f}"
    if decimal == "comma":
        text = text.translate(str.maketrans(",.", ".,"))
    return text + "%" if column.cells == "percent" else text


def _line(cells: list[str] | tuple[str, ...], draft: Draft) -> str:
    if draft.choice["delimiter"] == "spaces":
        width = max(len(column.name) for column in draft.columns) + 14
        return "".join(f"{cell:<{width}}" for cell in cells).rstrip()
    return draft.delimiter.join(f'"{cell}"' if draft.delimiter in cell or "\n" in cell else cell for cell in cells)


def _column_options(draft: Draft) -> list[str]:
    options: list[str] = []
    before = 2 if draft.stage_column else 1
    for place, column in enumerate(draft.columns, before):
        if column.quantity == "time":
            continue
        where = column.name if draft.choice["style"] == "row of units" else draft.rng.choice([str(place), chr(64 + place)])
        unit = f":{column.unit}" if draft.choice["style"] == "none" and column.unit else ""
        options += ["--column", f"{column.quantity}={where}{unit}"]
    return options
