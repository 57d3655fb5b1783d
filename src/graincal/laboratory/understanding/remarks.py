"""What the lines above a table, and its headers, say in words: pressures, void ratio, the sample's size, the kind of test, the measure and sign of strains."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isclose, pi

from graincal.laboratory.units import find_unit

_NUMBER = r"(?P<number>\d[\d.,]*(?:[eE][+-]?\d+)?)"
_UNIT = r"(?:\W*[\[(](?P<before>[^\d\])]+[²2]?)[\])])?\D*?" + _NUMBER + r"[\s\[(]*(?P<after>[A-Za-z][\w/²^]*)?"
_CONFINING_PRESSURE = re.compile(
    # Neither a preconsolidation, nor the largest pressure of an apparatus, nor a formula with σ3 in it.
    r"(?<![^\W\d_])(?<!max )(?<!max\. )(?<!maximum )(?<!pre-)(?<![-–/+*(])(?<![-–/+*] )(?P<effective>(?:eff(?:ective|ektive[rs]?|\.)?\s+)?)(?:(?:confining|cell|lateral|radial|chamber|consolidation)\s+(?:pressure|stress)|zell(?:en)?druck|zellspannung|seitendruck|seitenspannung|konsolidationsspannung|pression de confinement|"
    r"contrainte de confinement|presi[oó]n de (?:confinamiento|c[aá]mara)|tens[aã]o confinante|围压|(?:σ|sigma)[_ ]*[3c](?P<prime>['′])?(?!\s*[)/\]}*+]))(?P<behind>[ ,(]*(?:effective|effektiv|eff\.)\)?)?(?:[ ,(]*(?:σ|sigma)[_ ]*[3c]['′]?\)?)?"
    + _UNIT,
    re.IGNORECASE,
)
_BACK_PRESSURE = re.compile(
    r"(?:back[- ]?press(?:ure|\.)?|\bBP\b|\bu_?[0b]\b|\bpore(?:[- ]?water)? pressure|\bporenwasserdruck|\bpression interstitielle|\bpresi[oó]n de poros|sättigungsdruck|saettigungsdruck|gegendruck|backdruck|contre-?pression|contrapresi[oó]n|contrapress[aã]o|反压)"
    + _UNIT,
    re.IGNORECASE,
)
_VOID_RATIO = re.compile(
    r"(?P<before>[^,;|]{0,24}?)(?:(?:void[- ]ratio|porenzahl|indice des vides|[ií]ndice de (?:vac[ií]os|vazios|poros)|孔隙比|間隙比)"
    r"(?:,?\s*\(?\be(?:_?[0cₒ₀])?\b\)?)?|(?<![^\W_])e_?[0₀](?![^\W]))"
    r"(?:\s*\(?(?:initial|after consolidation|before shear(?:ing)?|of the (?:sample|specimen)|nach (?:der )?konsolidation|vor (?:dem )?abscheren|après consolidation|tras consolidación)\)?)?\s*(?:[:=,;]|\bis\b|\bof\b)?\s*"
    + _NUMBER
    + r"(?!\s*[-–%\d]|\s*to\b)",
    re.IGNORECASE,
)
_OF_LIMITS = re.compile(r"max|min|loose|dens(?:est|e\b)|lockerst|dichtest|critical|kritisch|limit|range|lâche|suelto|denso", re.IGNORECASE)
"""Before a void ratio: it is not the sample's."""
VOID_RATIOS_OF_SOIL = (0.1, 4.0)
SAME = 0.01
"""Pressures and sizes that are said twice are the same within this part."""
_SIZES = {
    "height": re.compile(r"(?:\bheight\b|\b(?:proben|anfangs)?höhe\b|\bhauteur\b|\baltura\b|\baltezza\b|высота|高度|高さ)" + _UNIT, re.IGNORECASE),
    "diameter": re.compile(r"(?:\bdiameter\b|\b(?:proben)?durchmesser\b|\bdiam[eè]tre\b|\bdi[aá]metro\b|\bdiametro\b|диаметр|直径)" + _UNIT, re.IGNORECASE),
    "volume": re.compile(r"\b(?:(?:initial|sample|specimen) volume|proben-?volumen|anfangsvolumen|volume initial|volumen inicial)\b" + _UNIT, re.IGNORECASE),
}
_OF_OTHER_THINGS = re.compile(r"\b(?:cap|platen|piston|cell|mould|mold|membrane|stone|disc|disk|fall|drop|hammer|layer|tube|ram)\b[^,;:]*$", re.IGNORECASE)
"""Before a height or a diameter: it is not the sample's."""
_AT_SHEAR = re.compile(
    r"after (?:isotropic |anisotropic )?consolidation|consolidated|(?:before|at start of) shear|nach (?:der )?konsolid|vor (?:dem )?abscher|après consolidation|tras (?:la )?consolidaci",
    re.IGNORECASE,
)
_UNDRAINED = re.compile(r"\bundrained\b|undr[aä]e?nier|non[- ]drain|no drenad|n[aã]o[- ]drenad|недренир|不排水|非排水", re.IGNORECASE)
_DRAINED = re.compile(
    r"(?<!un)\bdrained\b|(?<!un)dr[aä]e?niert|(?<!non )(?<!non-)\bdrain[ée]|(?<!no )(?<!não )\bdrenad|(?<!не)дренир|(?<!不)排水(?!量)", re.IGNORECASE
)
# In capitals alone, and no value behind: Cu is a coefficient of uniformity.
_ABBREVIATED = {"undrained": re.compile(r"\bC(?:I|K0|K₀)?U\b(?!\s*[=:<>≈]|\s+\d)"), "triaxial": re.compile(r"\bC(?:I|K0|K₀)?D\b(?!\s*[=:<>≈]|\s+\d)")}
_OEDOMETER = re.compile(
    r"[oö]e?dom|oedom|édom|edom[eé]t|одометр|компресси|one[- ]dimensional|1-?D (?:compression|consolidation)|\bCRS\b|consolidation test|压缩试验|圧密",
    re.IGNORECASE,
)
_ISOTROPIC = re.compile(
    r"isotropic (?:compression|consolidation)|isotrope (?:kompression|konsolidation)|compression isotrope|compresi[oó]n is[oó]tropa|等向压缩", re.IGNORECASE
)
_CONSTANT_MEAN = re.compile(
    r"constant[- ]p\b|constant[- ]mean[- ](?:effective[- ])?(?:normal[- ])?(?:stress|pressure)|\bp['′]?\s*=\s*const|\bp['′]?[- ](?:is )?(?:held |kept )?constant|p['′]?\s*=?\s*konstant",
    re.IGNORECASE,
)
_OTHER_TEST = re.compile(
    r"plane[- ]strain|direct shear|simple shear|shear box|ring shear|torsional shear|hollow cylinder|true triaxial|biaxial|unconfined|uniaxial compression|\bDSS\b|\bUCS\b|direktscher|rahmenscher|einaxial|cisaillement (?:direct|simple)"
    r"|corte directo|corte simple|cisalhamento direto|taglio diretto|直剪|平面应变|单剪|真三轴|无侧限",
    re.IGNORECASE,
)
_S1, _S3 = r"(?:σ|sigma|sig|s)['′_]*[1av]['′]?", r"(?:σ|sigma|sig|s)['′_]*[3rhc]['′]?"
_OF_MIT = re.compile(
    rf"\bMIT\b|q\s*=\s*\(\s*{_S1}\s*[-–]\s*{_S3}\s*\)\s*/\s*2|q\s*=\s*(?:0\.5|1/2|½)\s*[*·×]?\s*\(\s*{_S1}\s*[-–]\s*{_S3}|p['′]?\s*=\s*\(\s*{_S1}\s*\+\s*{_S3}\s*\)\s*/\s*2",
    re.IGNORECASE,
)
_STRAIN = r"(?:strains?|dehnung(?:en)?|stauchung|d[ée]formations?|deformaci[oó]n(?:es)?|deforma[cç][aã]o|деформаци\w*|应变|ひずみ|변형률)"
_MEASURES = {
    "logarithmic": r"(?:logar[ií]t\w*|логарифм\w*|对数|true|natural|hencky|log)",
    "engineering": r"(?:engineering|nominal|technische?\w*|ing[ée]nieur|nominale|nominell\w*|ingenieril|工程)",
}
"""Beside a word for strain, with two words between them at the most."""
_VOLUME = re.compile(r"dilat|contract|volum", re.IGNORECASE)
_SIGNS = {
    1.0: re.compile(
        r"(?:compression|contraction)\s*(?:is\s+|=\s*|taken\s+|as\s+|:\s*)*(?:positive|\+|pos\b)|positive in (?:compression|contraction)|dilat(?:ion|ancy)\s*(?:is\s+|=\s*|:\s*)?(?:negative|neg\b)",
        re.IGNORECASE,
    ),
    -1.0: re.compile(
        r"(?:compression|contraction)\s*(?:is\s+|=\s*|taken\s+|as\s+|:\s*)*(?:negative|neg\b)|negative in (?:compression|contraction)|positive in (?:dilat|tension|extension)"
        r"|(?:dilat(?:ion|ancy)|tension|extension)\s*(?:is\s+|=\s*|:\s*)?(?:positive|\+|pos\b)",
        re.IGNORECASE,
    ),
}


def confining_pressures(remarks: Sequence[str]) -> list[tuple[float, bool]]:
    """Those that are said, each in Pa and whether it is said to be effective: the effective ones alone where there are any, and each value once."""
    found = [
        (value, bool(said["effective"].strip() or said["behind"] or said["prime"]))
        for remark in remarks
        for said in _CONFINING_PRESSURE.finditer(remark)
        if (value := _with_unit(said, "pressure")) is not None
    ]
    found = [pressure for pressure in found if pressure[1]] or found
    return [pressure for at, pressure in enumerate(found) if not any(isclose(pressure[0], other[0], rel_tol=SAME) for other in found[:at])]


def back_pressure(remarks: Sequence[str]) -> float | None:
    """Pa; NaN for one that is spoken of, without a number in a known unit."""
    for remark in remarks:
        for found in _BACK_PRESSURE.finditer(remark):
            if (value := _with_unit(found, "pressure")) is not None:
                return value
        if re.search(
            r"back[- ]?press|\bBP\b|contre-?pression|contrapresi[oó]n|s[aä]e?ttigungsdruck|gegendruck|反压|\bskempton|\bB[- ]?(?:value|wert|check)\b",
            remark,
            re.IGNORECASE,
        ):
            return float("nan")
    return None


def void_ratios(remarks: Sequence[str]) -> list[float]:
    """The sample's void ratios that are said, each once; not the limits of its material."""
    found = [number(said["number"]) for remark in remarks for said in _VOID_RATIO.finditer(remark) if not _OF_LIMITS.search(said["before"])]
    low, high = VOID_RATIOS_OF_SOIL
    return list(dict.fromkeys(value for value in found if value is not None and low < value < high))


def sample_volume(remarks: Sequence[str]) -> float | None:
    """m³, said or of a cylinder's height and diameter."""
    sizes = {name: _size(remarks, name) for name in _SIZES}
    if sizes["volume"]:
        return sizes["volume"]
    return pi / 4 * sizes["diameter"] ** 2 * sizes["height"] if sizes["height"] and sizes["diameter"] else None


def sample_height(remarks: Sequence[str]) -> float | None:
    """m."""
    return _size(remarks, "height")


def _size(remarks: Sequence[str], name: str) -> float | None:
    """A size of the sample, where the shear begins if that is said; None without one, and for several that differ."""
    said = [
        (value, bool(_AT_SHEAR.search(remark)))
        for remark in remarks
        for found in _SIZES[name].finditer(remark)
        if (value := _with_unit(found, "volume" if name == "volume" else "length")) is not None and not _OF_OTHER_THINGS.search(remark[: found.start()])
    ]
    values = [value for value, at_shear in said if at_shear] or [value for value, _ in said]
    return values[0] if values and all(isclose(value, values[0], rel_tol=SAME) for value in values) else None


def kind(words: Sequence[str]) -> str | None:
    """The kind of test that is said: "triaxial" for a drained one; None where nothing is said, or more than one kind."""
    text = " ".join(words)
    said = {
        name
        for name, pattern in (("undrained", _UNDRAINED), ("triaxial", _DRAINED), ("oedometric", _OEDOMETER), ("isotropic", _ISOTROPIC))
        if pattern.search(_UNDRAINED.sub(" ", text) if name == "triaxial" else text)
    }
    said |= {name for name, pattern in _ABBREVIATED.items() if pattern.search(text)}
    if said <= {"triaxial"} and any(map(_CONSTANT_MEAN.search, words)):
        return "constant-mean-stress"
    return said.pop() if len(said) == 1 else None


def other_test(words: Sequence[str]) -> str | None:
    """A test that is said and that no kind is of: a shear box, a plane strain test."""
    return next((found[0] for word in words if (found := _OTHER_TEST.search(word))), None)


def of_mit(words: Sequence[str]) -> bool:
    """Whether p and q are said to be (σ1 + σ3)/2 and (σ1 - σ3)/2."""
    return any(_OF_MIT.search(word) for word in words)


def strain_measure(words: Sequence[str]) -> str | None:
    texts = [re.sub(r"[\W_]+", " ", word) for word in words]
    said = [
        measure
        for measure, pattern in _MEASURES.items()
        if any(re.search(rf"\b{pattern}(?: \w+){{0,2}} {_STRAIN}|{_STRAIN}(?: \w+){{0,2}} {pattern}\b", text, re.IGNORECASE) for text in texts)
    ]
    return said[0] if len(said) == 1 else None


def sign(words: Sequence[str], *, of_volume: bool) -> float | None:
    """1.0 where compression is said to be positive, -1.0 where it is negative: of the volume, or of all strains and stresses."""
    told = [word for word in words if of_volume or not _VOLUME.search(word)]
    said = {value for word in told for value, pattern in _SIGNS.items() if pattern.search(word)}
    of_it = {value for word in told if _VOLUME.search(word) for value, pattern in _SIGNS.items() if pattern.search(word)}
    said = of_it or said
    return said.pop() if len(said) == 1 else None


def number(text: str) -> float | None:
    """A number in a remark, unless its comma may part thousands."""
    text = text.rstrip(".,")
    try:
        return None if re.search(r",\d{3}(\D|$)", text) else float(text.replace(",", "."))
    except ValueError:
        return None


def _with_unit(found: re.Match | None, dimension: str) -> float | None:
    unit = find_unit(found["before"] or found["after"] or "?") if found else None
    value = number(found["number"]) if found else None
    return None if unit is None or not value or unit.dimension != dimension else value * unit.factor
