"""How the quantities are called, by the style of a header."""

from __future__ import annotations

from collections.abc import Mapping

Words = Mapping[str, tuple[str, ...]]

CANONICAL: Words = {
    quantity: (quantity,)
    for quantity in (
        "axial_strain", "volumetric_strain", "radial_strain", "deviator_stress", "axial_stress", "lateral_stress", "mean_stress", "pore_pressure",
        "total_axial_stress", "total_lateral_stress", "stress_ratio", "deviator_to_mean_stress", "void_ratio", "porosity",
    )
}  # fmt: skip
ENGLISH: Words = {
    "axial_strain": ("Axial strain", "Axial Strain"),
    "volumetric_strain": ("Volumetric strain", "Vol. strain"),
    "radial_strain": ("Radial strain", "Lateral strain"),
    "deviator_stress": ("Deviator stress", "Deviatoric stress q"),
    "axial_stress": ("Effective axial stress", "Axial effective stress"),
    "lateral_stress": ("Effective radial stress", "Effective lateral stress"),
    "mean_stress": ("Mean effective stress", "Effective mean stress p'"),
    "s": ("s'",),
    "t": ("t",),
    "pore_pressure": ("Pore pressure", "Pore water pressure"),
    "total_axial_stress": ("Total axial stress",),
    "total_lateral_stress": ("Total radial stress", "Cell pressure"),
    "stress_ratio": ("Stress ratio σ1'/σ3'", "Effective principal stress ratio"),
    "deviator_to_mean_stress": ("q/p'",),
    "void_ratio": ("Void ratio", "Void ratio e"),
    "porosity": ("Porosity", "Porosity n"),
}
SYMBOLS: Words = {
    "axial_strain": ("ε1", "εa"),
    "volumetric_strain": ("εv", "ε_v"),
    "radial_strain": ("ε3", "εr"),
    "deviator_stress": ("q", "σ1-σ3"),
    "axial_stress": ("σ1'", "σ'1"),
    "lateral_stress": ("σ3'", "σ'3"),
    "mean_stress": ("p'",),
    "s": ("s'",),
    "t": ("t",),
    "pore_pressure": ("u",),
    "total_axial_stress": ("σ1",),
    "total_lateral_stress": ("σ3",),
    "stress_ratio": ("σ1'/σ3'",),
    "deviator_to_mean_stress": ("q/p'",),
    "void_ratio": ("e",),
    "porosity": ("n",),
}
EXTENSION_SYMBOLS: Words = {
    **SYMBOLS,
    "axial_strain": ("εa",),
    "radial_strain": ("εr",),
    "deviator_stress": ("q",),
    "axial_stress": ("σa'", "σ'a"),
    "lateral_stress": ("σr'", "σ'r"),
    "total_axial_stress": ("σa",),
    "total_lateral_stress": ("σr",),
    "stress_ratio": ("σa'/σr'",),
}
LETTERS: Words = {
    "axial_strain": ("eps1", "eps_a"),
    "volumetric_strain": ("epsv", "eps_v"),
    "radial_strain": ("eps3", "eps_r"),
    "deviator_stress": ("q", "sigma1-sigma3"),
    "axial_stress": ("sigma1'", "sigma'_1"),
    "lateral_stress": ("sigma3'", "sigma'_3"),
    "mean_stress": ("p'",),
    "s": ("s'",),
    "t": ("t",),
    "pore_pressure": ("u",),
    "total_axial_stress": ("sigma1",),
    "total_lateral_stress": ("sigma3",),
    "stress_ratio": ("sigma1'/sigma3'",),
    "deviator_to_mean_stress": ("q/p'",),
    "void_ratio": ("e",),
    "porosity": ("n",),
}
EXTENSION_LETTERS: Words = {
    **LETTERS,
    "axial_strain": ("eps_a",),
    "radial_strain": ("eps_r",),
    "deviator_stress": ("q",),
    "axial_stress": ("sigma_a'", "sigma'_a"),
    "lateral_stress": ("sigma_r'", "sigma'_r"),
    "total_axial_stress": ("sigma_a",),
    "total_lateral_stress": ("sigma_r",),
    "stress_ratio": ("sigma_a'/sigma_r'",),
}


def _language(words: str) -> Words:
    """Words of another language, in the order of the quantities below."""
    quantities = (
        "axial_strain", "volumetric_strain", "radial_strain", "deviator_stress", "axial_stress", "lateral_stress", "mean_stress", "pore_pressure",
        "total_axial_stress", "total_lateral_stress", "void_ratio", "porosity",
    )  # fmt: skip
    return dict(zip(quantities, ((word.strip(),) for word in words.split("|")), strict=True))


LANGUAGES = {
    "German": _language(
        "Axialdehnung | Volumendehnung | Radialdehnung | Deviatorspannung | effektive Axialspannung | effektive Radialspannung | mittlere effektive Spannung"
        " | Porenwasserdruck | totale Axialspannung | Zelldruck | Porenzahl | Porenanteil"
    ),
    "French": _language(
        "Déformation axiale | Déformation volumique | Déformation radiale | Contrainte déviatorique | Contrainte axiale effective"
        " | Contrainte radiale effective | Contrainte moyenne effective | Pression interstitielle | Contrainte axiale totale | Pression de cellule"
        " | Indice des vides | Porosité"
    ),
    "Spanish": _language(
        "Deformación axial | Deformación volumétrica | Deformación radial | Esfuerzo desviador | Esfuerzo axial efectivo | Esfuerzo radial efectivo"
        " | Esfuerzo medio efectivo | Presión de poros | Esfuerzo axial total | Presión de celda | Relación de vacíos | Porosidad"
    ),
    "Portuguese": _language(
        "Deformação axial | Deformação volumétrica | Deformação radial | Tensão desviadora | Tensão axial efetiva | Tensão radial efetiva"
        " | Tensão média efetiva | Poropressão | Tensão axial total | Pressão da célula | Índice de vazios | Porosidade"
    ),
    "Italian": _language(
        "Deformazione assiale | Deformazione volumetrica | Deformazione radiale | Tensione deviatorica | Tensione assiale efficace"
        " | Tensione radiale efficace | Tensione media efficace | Pressione interstiziale | Tensione assiale totale | Pressione di cella"
        " | Indice dei vuoti | Porosità"
    ),
    "Russian": _language(
        "Осевая деформация | Объемная деформация | Радиальная деформация | Девиатор напряжений | Осевое эффективное напряжение"
        " | Боковое эффективное напряжение | Среднее эффективное напряжение | Поровое давление | Полное осевое напряжение | Давление в камере"
        " | Коэффициент пористости | Пористость"
    ),
    "Chinese": _language(
        "轴向应变 | 体积应变 | 径向应变 | 偏应力 | 有效轴向应力 | 有效围压 | 平均有效应力 | 孔隙水压力 | 总轴向应力 | 总围压 | 孔隙比 | 孔隙率"
    ),
}
ENCODINGS = {"Russian": "cp1251", "Chinese": "gbk", "German": "cp1252", "French": "cp1252", "Spanish": "cp1252", "Portuguese": "cp1252", "Italian": "cp1252"}

STYLES = ("canonical", "name [unit]", "name (unit)", "name, unit", "row of units", "two lines", "symbols", "letters", "in a comment", "none", *LANGUAGES)


def words(style: str, extension: bool, compression_line: bool) -> Words:
    """The words of a style; a specimen that is only compressed has a vertical axis."""
    if style in LANGUAGES:
        return LANGUAGES[style]
    if style == "symbols":
        return EXTENSION_SYMBOLS if extension else SYMBOLS
    if style == "letters":
        return EXTENSION_LETTERS if extension else LETTERS
    if style in ("canonical", "none"):
        return CANONICAL
    if compression_line:
        return {**ENGLISH, "axial_stress": ("Vertical effective stress", "Effective vertical stress"), "axial_strain": ("Vertical strain", "Axial strain")}
    return ENGLISH
