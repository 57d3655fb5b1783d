"""What quantities are called in laboratories: in English, German, French, Spanish, Portuguese, Italian, Dutch, Polish, Czech, Turkish, Russian, Chinese, Japanese and Korean."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from dataclasses import dataclass

from graincal.laboratory.quantities import STRESS_MEASURES
from graincal.laboratory.units import Unit, find_unit, split_header
from graincal.suggestion import did_you_mean

_CALLED = {
    "axial_strain": "axialstrain axstrain strainaxial verticalstrain majorstrain majorprincipalstrain epsa epsaxial epsilona epsilonaxial ea eaxial eps1 epsilon1 e1 epsz epszz ezz epsy1 eax "
    "axialdehnung axialedehnung dehnung axialstauchung axialestauchung stauchung axialverformung axialeverformung vertikaldehnung vertikalstauchung vertikaleverformung "
    "deformationaxiale deformationverticale deformacionaxial deformacionunitariaaxial deformacionunitaria deformacionvertical deformaxial deformacaoaxial deformacaoespecificaaxial deformacaovertical "
    "deformazioneassiale deformazioneverticale axialerek verticalerek axialevervorming odksztalcenieosiowe osovapretvoreni osovadeformace eksenelbirimdeformasyon eksenelsekildegistirme eksenelgerinim "
    "осеваядеформация осеваяотносительнаядеформация вертикальнаядеформация относительнаявертикальнаядеформация продольнаядеформация относительнаяосеваядеформация "
    "轴向应变 轴应变 軸ひずみ 軸方向ひずみ 축변형률 축방향변형률 tgstraxial",
    "volumetric_strain": "volumetricstrain volstrain volumestrain strainvolumetric epsv epsvol epsilonv epsilonvol ev evol epsp volumetricdeformation "
    "volumendehnung volumetrischedehnung volumenstauchung volumenverformung volumetrischeverformung "
    "deformationvolumique deformationvolumetrique deformacionvolumetrica deformacionunitariavolumetrica deformvol deformacaovolumetrica deformacaoespecificavolumetrica deformvolumetrica "
    "deformazionevolumetrica volumerek volumetrischerek odksztalcenieobjetosciowe objemovepretvoreni objemovadeformace hacimselbirimdeformasyon hacimselsekildegistirme hacimselgerinim "
    "объемнаядеформация объёмнаядеформация относительнаяобъемнаядеформация объемнаяотносительнаядеформация 体积应变 体应变 体積ひずみ 체적변형률",
    "radial_strain": "radialstrain lateralstrain minorstrain horizontalstrain epsr epsilonr er erad eradial eps3 epsilon3 e3 "
    "radialdehnung radialedehnung querdehnung radialverformung deformationradiale deformationlaterale deformacionradial deformacionlateral deformacaoradial deformacaolateral deformazioneradiale radialerek "
    "радиальнаядеформация поперечнаядеформация боковаядеформация 径向应变 侧向应变 側方ひずみ 半径方向ひずみ 횡방향변형률",
    "stress_ratio": "stressratio principalstressratio s1/s3 sigma1/sigma3 sigma1/3 s1overs3 sigma1oversigma3 sig1/sig3 sa/sr s33overs11 szzoversxx "
    "sigmaa/sigmar s1/sc sz/sx majortominorstressratio "
    "spannungsverhaltnis spannungsverhaeltnis hauptspannungsverhaltnis hauptspannungsverhaeltnis rapportdecontraintes rapportdescontraintes "
    "relaciondetensiones relaciondeesfuerzos razaodetensoes rapportoditensione rapportotraletensioni отношениенапряжений 应力比 主应力比 応力比 主応力比 응력비",
    "deviator_stress": "deviatorstress deviatoricstress devstress deviator q s1-s3 sigma1-sigma3 sig1-sig3 sigmad sa-sr sigmaa-sigmar principalstressdifference stressdifference "
    "stressdeviator dsigma deltasigma deviatorstres "
    "deviatorspannung deviatorischespannung spannungsdeviator hauptspannungsdifferenz spannungsdifferenz "
    "deviateur deviateurdecontrainte deviateurdecontraintes deviateurdescontraintes contraintedeviatorique "
    "esfuerzodesviador tensiondesviadora desviador tensiondesviatorica esfuerzodesviatorico tensaodesviadora tensaodesvio tensaodesviatoria tensiaodesviadora desviatoria tensionedeviatorica sforzodeviatorico deviatore "
    "deviatorspanning naprezeniedewiatorowe dewiatornaprezenia dewiator deviatornapeti deviatorgerilme deviatorikgerilme "
    "девиатор девиаторнапряжений девиаторноенапряжение разностьглавныхнапряжений 偏应力 偏差应力 主应力差 偏応力 軸差応力 主応力差 축차응력",
    "half_difference_stress": "t s12 halfdeviatorstress maximumshearstress maxshearstress (s1-s3)/2 (sigma1-sigma3)/2 (sig1-sig3)/2 (sigmaa-sigmar)/2 q/2 "
    "halbespannungsdifferenz 最大剪应力",
    "half_sum_stress": "s (s1+s3)/2 (sigma1+sigma3)/2 (sig1+sig3)/2 (sigmaa+sigmar)/2 meanplanestress",
    "mean_stress": "p meanstress meannormalstress meanprincipalstress averagestress isotropicstress pm sigmam (s1+2s3)/3 (sigma1+2sigma3)/3 (sigmaa+2sigmar)/3 octahedralstress "
    "mittlerespannung mittlerenormalspannung mittlerehauptspannung mitteldruck contraintemoyenne pressionmoyenne tensionmedia esfuerzomedio presionmedia tensaomedia tensaonormalmedia tensionemedia pressionemedia "
    "gemiddeldespanning naprezeniesrednie srednienaprezenie strednina stredninapeti ortalamagerilme среднеенапряжение среднееэффективноенапряжение 平均应力 平均主应力 平均正应力 平均応力 平均主応力 평균응력 평균주응력",
    "axial_stress": "axialstress s1 sigma1 sig1 sigmaa sigmaaxial sa sigmaz sigmazz szz verticalstress majorprincipalstress verticalpressure verticaleffectivestress effectiveverticalstress appliedpressure appliedstress appliedverticalstress loadingpressure sigmav sv axialpressure normalstress verticalload "
    "axialspannung axialespannung vertikalspannung hauptspannung hauptspannung1 1hauptspannung grosstehauptspannung vertikalenormalspannung "
    "groesstehauptspannung contrainteaxiale contrainteprincipalemajeure contrainteverticale tensionaxial esfuerzoaxial tensionvertical esfuerzovertical tensaoaxial tensaovertical tensioneassiale tensioneverticale "
    "axialespanning verticalespanning naprezenieosiowe naprezeniepionowe osovenapeti svislenapeti eksenelgerilme duseygerilme "
    "осевоенапряжение вертикальноенапряжение вертикальноедавление 轴向应力 轴应力 竖向应力 竖向压力 垂直压力 軸応力 軸方向応力 鉛直応力 축응력 연직응력 consincf",
    "lateral_stress": "confiningpressure confiningstress cellpressure sigma3 s3 sig3 sigmac sc sigmar sr radialstress lateralstress radialpressure lateralpressure cellstress sigmah sh horizontalstress minorprincipalstress "
    "chamberpressure chamberstress sxx sigmaxx sigmax "
    "zelldruck seitendruck radialspannung hauptspannung3 3hauptspannung hauptspannungsigma3 kleinstehauptspannung horizontalspannung seitenspannung "
    "pressiondeconfinement contraintedeconfinement pressioncellulaire pressiondecellule pressiondelacellule contrainteradiale contraintelaterale contrainteprincipalemineure "
    "presiondeconfinamiento presiondecamara presiondecelda tensionradial esfuerzoradial tensiondeconfinamiento esfuerzodeconfinamiento tensaoconfinante pressaoconfinante tensaodeconfinamento pressaodeconfinamento tensaoradial "
    "pressionedicella pressionediconfinamento tensioneradiale celdruk radialespanning zijdelingsespanning cisnieniewkomorze naprezenieboczne komorovytlak hucrebasinci cevrebasinci yanalgerilme "
    "боковоедавление боковоенапряжение давлениевкамере всестороннеедавление радиальноенапряжение 围压 侧压 径向应力 有效围压 拘束圧 側圧 セル圧 側方応力 구속압 구속응력 측압",
    "pore_pressure": "porepressure porewaterpressure pwp u uw porep waterpressure porenwasserdruck porenwasserdruckes porendruck pressioninterstitielle pressiondeseau pressiondeleau "
    "presiondeporos presionintersticial presionporo poropressao pressaoneutra pressaodeporos pressioneinterstiziale pressioneneutra waterspanning poriendruk cisnienieporowe porovytlak boslukbasinci boslukusuyubasinci "
    "поровоедавление давлениевпорах 孔压 孔隙水压力 孔隙压力 孔隙水压 間隙水圧 간극수압",
    "excess_pore_pressure": "excessporepressure excessporewaterpressure excesspwp du deltau porepressurechange changeinporepressure porenwasseruberdruck porenwasserueberdruck surpressioninterstitielle "
    "excesodepresiondeporos excessodeporopressao избыточноепоровоедавление 超孔压 超静孔压 超孔隙水压力 過剰間隙水圧 과잉간극수압",
    "back_pressure": "backpressure bp ub saturationpressure sattigungsdruck saettigungsdruck backdruck contrepression contrapresion contrapressao contropressione обратноедавление противодавление 反压 バックプレッシャー 背圧 배압",
    "deviator_to_mean_stress": "q/p eta qoverp deviatortomeanstress etaq/p eta=q/p",
    "void_ratio": "voidratio e porenzahl indicedesvides indicedevides relaciondevacios indicedevacios indicedeporos indicedevazios indicedeivuoti indicedivuoti poriegetal wskaznikporowatosci cisloporovitosti boslukorani "
    "коэффициентпористости 孔隙比 間隙比 간극비 consince",
    "initial_void_ratio": "initialvoidratio e0 anfangsporenzahl consivr",
    "porosity": "porosity n poros porosityn porositat porositaet porenanteil porosite porosidad porosidade porosita porositeit porowatosc porovitost porozite пористость 孔隙率 間隙率 간극률",
    "specific_volume": "specificvolume v spezifischesvolumen volumespecifique volumenespecifico volumeespecifico удельныйобъем",
    "volume_change": "volumechange changeinvolume deltav dv volchange samplevolumechange volumenanderung volumenaenderung variationdevolume cambiodevolumen variaciondevolumen variacaodevolume variazionedivolume volumeverandering "
    "изменениеобъема 体积变化 体变 体変量 排水量 체적변화",
    "axial_displacement": "axialdisplacement verticaldisplacement displacement deltah dh settlement axialdeformation weg setzung axialverschiebung deplacementaxial deplacement desplazamientoaxial desplazamiento deslocamentoaxial deslocamento spostamentoassiale spostamento "
    "осевоеперемещение перемещение 轴向位移 位移 軸変位 변위",
    "stage": "stage stagenumber stageno stagename phase stufe teststage etape etapa fase estagio fasenumero стадия этап 阶段 ステージ 단계",
    "time": "time elapsedtime timesincestart timesincestartoftest timesincestartofstage zeit temps tiempo tempo czas cas zaman время 时间 時間 시간",
}
"""Without capitals, accents, blanks and dots."""
SYMBOLS = ("p", "q", "pm")
"""Names that are defined in more than one way: p and q are of Cambridge or of MIT."""
_WITH_TWO_KINDS = {
    "axial_stress",
    "lateral_stress",
    "mean_stress",
    "half_sum_stress",
    "deviator_stress",
    "half_difference_stress",
    "stress_ratio",
    "deviator_to_mean_stress",
}
"""Stresses that are effective or total ones, or follow from them."""
_PRIMES = str.maketrans(dict.fromkeys("′’‘`´", "'"))
_GREEK = str.maketrans({"ε": "eps", "ϵ": "eps", "σ": "sigma", "η": "eta", "Δ": "delta", "δ": "delta", "₁": "1", "₃": "3", "ₐ": "a", "ᵥ": "v", "ᵣ": "r"})
_TRAILING_UNIT = re.compile(r"^(?P<name>.*?[^\s,/_])(?:\s*[,/;]\s*|\s+(?:in\s+|en\s+|em\s+)?|_)(?P<unit>[^\s,_]+)$")
_EFFECTIVE = re.compile(
    r"effective|effektive?[rs]?|\beff\b\.?|efectiv[oa]|efetiv[oa]|effica(?:ce|cite)|effettiv[oa]|эффективн\w*|有效|有効|유효", re.IGNORECASE
)
_TOTAL = re.compile(r"\btotal(?:e|es|en|er)?\b|\bgesamt(?:e|er)?|полн\w+|总|全(?=応力)", re.IGNORECASE)
_CELL = re.compile(r"cell|chamber|zelldruck|cellul|c[aá]mara|celda|cella|celdruk|komor|hücre|hucre|камер|セル|室压|围压室", re.IGNORECASE)
_QUALIFIER = re.compile(
    r"(?:effective|eff\.?|total|corrected|corr\.?|uncorrected|average|avg\.?|mean|measured|external|internal|local|global|lvdt|drained|undrained|positive|negative|\+ ?ve|logarithmic|engineering|"
    r"nominal|true|hencky|natural|(?:compression|contraction|dilation|tension|extension)\b.*)",
    re.IGNORECASE,
)
"""What stands in brackets behind a name and is no unit."""
_CORRECTED = re.compile(
    r"[\[(]?\b(?:membrane|area|rubber|un)?[ -]?(?:corrected|corr)\b\.?[\])]?|[\[(]?\b(?:external|internal|local|global|measured|average|avg|lvdt)\b\.?[\])]?",
    re.IGNORECASE,
)
"""How a quantity was measured, or what was corrected of it: columns that differ in this alone are of one quantity."""


@dataclass(frozen=True)
class Meaning:
    """What a header says: the quantity (None for an unknown one), its unit, and text in the place of a unit that is none that is known (empty for none).

    effective: whether a stress is said to be effective or total; None where nothing is said. symbol: whether it is p or q alone, which have more than one definition.
    """

    quantity: str | None
    unit: Unit | None = None
    unknown_unit: str = ""
    effective: bool | None = None
    symbol: bool = False
    cell: bool = False


def meaning(header: str) -> Meaning:
    """What a header seems to say: `Ea(%)`, `eps_v, %`, `q kPa`, `σ1'/σ3'`, `Eff. axial stress [psi]`. For proposals that a person checks, never for a calibration."""
    header = header.translate(_PRIMES).lstrip("*#%! ")
    name, text = split_header(header)
    unit = find_unit(text) if text is not None else None
    if text is not None and unit is None:
        if (whole := _known(header)) is not None:
            return _with_kind(header, whole, None)
        inner = meaning(name)
        qualifies = _QUALIFIER.fullmatch(text) or _QUANTITY.get(_plain(text)) == inner.quantity
        return _with_kind(header, inner.quantity, inner.unit, "" if inner.unit or qualifies else text)
    quantity = _known(name)
    if quantity is None and unit is None and (found := _TRAILING_UNIT.match(header)):
        trailing = find_unit(found["unit"])
        if trailing is not None and (trailing.symbol != "-" or "/" in found["unit"]):
            return _with_kind(found["name"], _known(found["name"]), trailing)
    return _with_kind(name, quantity, unit)


def guess(header: str) -> tuple[str | None, Unit | None]:
    """The quantity that a header seems to name and the unit it seems to carry."""
    said = meaning(header)
    return said.quantity, said.unit


def did_you_mean_observable(name: str, known: Collection[str]) -> str:
    """` (did you mean "stress_ratio"?)`, to stand behind an observable that is not known: by its spelling, or as another name of a known quantity."""
    quantity = guess(name)[0]
    if quantity in STRESS_MEASURES and quantity not in known:
        quantity = "stress_ratio"
    return f' (did you mean "{quantity}"?)' if quantity in known else did_you_mean(name, known)


def _with_kind(name: str, quantity: str | None, unit: Unit | None, unknown_unit: str = "") -> Meaning:
    """With whether a stress is said to be effective, and whether it is the symbol p or q."""
    if quantity not in _WITH_TWO_KINDS:
        return Meaning(quantity, unit, unknown_unit)
    spaced = name.replace("_", " ")
    effective = True if "'" in name or _EFFECTIVE.search(spaced) else False if _TOTAL.search(spaced) else None
    cell = quantity == "lateral_stress" and _CELL.search(spaced) is not None
    return Meaning(quantity, unit, unknown_unit, effective, _plain(_bare(split_header(name)[0])) in SYMBOLS, cell)


def _bare(name: str) -> str:
    """Without the words for effective and total."""
    return _TOTAL.sub(" ", _EFFECTIVE.sub(" ", name.replace("_", " "))).strip(" ,;:.-")


def _known(name: str) -> str | None:
    """The quantity of a name, or of a name with its symbol before or behind it: `Deviator stress q`, `Volumetric strain, ε_v`, `Deviator stress (σ1-σ3)`."""
    name = _bare(name)
    if quantity := _QUANTITY.get(_plain(name)):
        return quantity
    before, _, behind = name.rpartition(" ")
    first, _, others = name.partition(" ")
    pairs = [(before, behind), (others, first)]
    if bracketed := re.fullmatch(r"(.*\S)\s*[\[(](.*)[\])]", name):
        pairs.append((bracketed[1], bracketed[2]))
    if quantity := next(
        (quantity for words, symbol in pairs if (quantity := _QUANTITY.get(_plain(words))) and quantity == _QUANTITY.get(_plain(symbol))), None
    ):
        return quantity
    # q = (σ1 - σ3)/2: what stands behind defines it.
    shorter = name.partition("=")[2] or _CORRECTED.sub(" ", name)
    return _known(shorter) if shorter.strip() and shorter != name else None


def _plain(name: str) -> str:
    """Without capitals, accents, blanks and dots, and Greek letters in words."""
    parted = unicodedata.normalize("NFKD", name.casefold().translate(_GREEK))
    return re.sub(r"[\s_.,:'^{}\\$()\[\]]+", "", "".join(letter for letter in parted if not unicodedata.combining(letter)))


_QUANTITY = {_plain(synonym): quantity for quantity, synonyms in _CALLED.items() for synonym in synonyms.split()}
