"""What a laboratory measures: canonical names, dimensions, what they are called elsewhere, and the stress ratio from each measure of stress."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.units import Unit, find_unit, split_header
from graincal.suggestion import did_you_mean

STRAINS = ("axial_strain", "volumetric_strain", "radial_strain")
STRESSES = ("deviator_stress", "axial_stress")
SIGNED = STRAINS + STRESSES
DIMENSIONS = (
    dict.fromkeys((*STRAINS, "stress_ratio", "deviator_to_mean_stress", "void_ratio"), "fraction")
    | dict.fromkeys((*STRESSES, "confining_pressure"), "pressure")
)
"""The dimension that a known quantity must have; a quantity of any other name may have any."""
OBSERVABLES = ("stress_ratio", "volumetric_strain", "void_ratio", "radial_strain")
"""What is mostly compared."""


@dataclass(frozen=True)
class StressMeasure:
    """How the stress ratio σ1/σ3 follows from a measured stress at a constant lateral stress (Pa)."""

    needs_confining_pressure: bool
    ratio: Callable[[NDArray[np.float64], float], NDArray[np.float64]]


STRESS_MEASURES = {
    "deviator_stress": StressMeasure(True, lambda q, confining: 1.0 + q / confining),
    "axial_stress": StressMeasure(True, lambda sigma_1, confining: sigma_1 / confining),
    # q = σ1 - σ3 and p = (σ1 + 2 σ3)/3; beyond q/p = 3 the lateral stress would be tension.
    "deviator_to_mean_stress": StressMeasure(False, lambda eta, _: (3.0 + 2.0 * eta) / (3.0 - eta)),
}

LARGEST_STRESS_RATIO = 100.0
"""No soil comes near; a larger one is a confining pressure in another unit than pascals."""
SHEARED = 0.05
"""How far from 1 the stress ratio of a sheared sample comes at the least, somewhere in its test: soils fail at 2 to 5."""


def unsheared(lowest: float, highest: float) -> str | None:
    """What is to be said of a stress ratio that stays at 1, between its lowest and its highest value; None for one that does not."""
    if max(abs(lowest - 1), abs(highest - 1)) > SHEARED:
        return None
    return f"the stress ratio stays between {lowest:.4g} and {highest:.4g}, as if the sample were never sheared: is the unit of the stress right, and the confining pressure?"


_CALLED = {
    "axial_strain": "axialstrain axstrain strainaxial verticalstrain majorstrain epsa epsaxial epsilona epsilonaxial ea eaxial eps1 "
    "epsilon1 e1 epsz epszz ezz "
    "axialdehnung axialedehnung dehnung axialstauchung axialestauchung stauchung axialverformung axialeverformung vertikaldehnung vertikalstauchung "
    "deformationaxiale deformationverticale",
    "volumetric_strain": "volumetricstrain volstrain volumestrain strainvolumetric epsv epsvol epsilonv epsilonvol ev evol epsp "
    "volumendehnung volumetrischedehnung volumenstauchung volumenverformung volumetrischeverformung "
    "deformationvolumique deformationvolumetrique",
    "radial_strain": "radialstrain lateralstrain epsr epsilonr er erad eradial eps3 epsilon3 e3 "
    "radialdehnung radialedehnung querdehnung radialverformung deformationradiale deformationlaterale",
    "stress_ratio": "stressratio principalstressratio s1/s3 sigma1/sigma3 sigma1/3 s1overs3 sigma1oversigma3 sig1/sig3 sa/sr "
    "sigmaa/sigmar s1/sc "
    "spannungsverhaltnis spannungsverhaeltnis hauptspannungsverhaltnis hauptspannungsverhaeltnis rapportdecontraintes rapportdescontraintes",
    "deviator_stress": "deviatorstress deviatoricstress devstress deviator q s1-s3 sigma1-sigma3 sig1-sig3 sigmad sa-sr sigmaa-sigmar "
    "stressdeviator "
    "deviatorspannung deviatorischespannung spannungsdeviator hauptspannungsdifferenz spannungsdifferenz "
    "deviateur deviateurdecontrainte deviateurdecontraintes deviateurdescontraintes contraintedeviatorique",
    "axial_stress": "axialstress s1 sigma1 sig1 sigmaa sigmaaxial sa sigmaz sigmazz szz verticalstress majorprincipalstress "
    "effectiveaxialstress "
    "axialspannung axialespannung vertikalspannung hauptspannung hauptspannung1 1hauptspannung grosstehauptspannung "
    "groesstehauptspannung contrainteaxiale contrainteprincipalemajeure",
    "deviator_to_mean_stress": "q/p eta qoverp deviatortomeanstress",
    "void_ratio": "voidratio e porenzahl indicedesvides",
    "confining_pressure": "confiningpressure confiningstress cellpressure sigma3 s3 sig3 sigmac sc sigmar sr radialstress lateralstress "
    "chamberpressure "
    "zelldruck seitendruck radialspannung hauptspannung3 3hauptspannung hauptspannungsigma3 kleinstehauptspannung "
    "pressiondeconfinement contraintedeconfinement pressioncellulaire",
}
"""In English, German and French; without capitals, accents, blanks and dots."""
_QUANTITY = {synonym: quantity for quantity, synonyms in _CALLED.items() for synonym in synonyms.split()}
_GREEK = str.maketrans({"ε": "eps", "ϵ": "eps", "σ": "sigma", "η": "eta", "₁": "1", "₃": "3", "ₐ": "a", "ᵥ": "v"})
_TRAILING_UNIT = re.compile(r"^(?P<name>.*?[^\s,/_])(?:\s*[,/]\s*|\s+(?:in\s+|en\s+)?|_)(?P<unit>[^\s,_]+)$")


def guess(header: str) -> tuple[str | None, Unit | None]:
    """The quantity that a header seems to name and the unit it seems to carry: `Ea(%)`, `eps_v, %`, `q kPa`, `σ1/σ3`.

    For proposals that a person checks, never for a calibration.
    """
    name, text = split_header(header)
    unit = find_unit(text) if text is not None else None
    if text is not None and unit is None:
        bare, _ = guess(name)
        return (bare or _known(header)), None
    if (quantity := _known(name)) is None and unit is None and (found := _TRAILING_UNIT.match(header)):
        trailing = find_unit(found["unit"])
        if trailing is not None and trailing.symbol != "-":
            return _known(found["name"]), trailing
    return quantity, unit


def did_you_mean_observable(name: str, known: Collection[str]) -> str:
    """` (did you mean "stress_ratio"?)`, to stand behind an observable that is not known: by its spelling, or as another name of a known quantity."""
    quantity = guess(name)[0]
    if quantity in STRESS_MEASURES and quantity not in known:
        quantity = "stress_ratio"
    return f' (did you mean "{quantity}"?)' if quantity in known else did_you_mean(name, known)


def _known(name: str) -> str | None:
    """The quantity of a name, or of a name with its symbol behind it: `Deviator stress q`."""
    words, _, symbol = name.rpartition(" ")
    quantity = _QUANTITY.get(_plain(words))
    return _QUANTITY.get(_plain(name)) or (quantity if quantity == _QUANTITY.get(_plain(symbol)) else None)


def _plain(name: str) -> str:
    parted = unicodedata.normalize("NFKD", name.casefold().translate(_GREEK))
    return re.sub(r"[\s_.'′’^{}\\$()\[\]]+", "", "".join(letter for letter in parted if not unicodedata.combining(letter)))
