"""Units of the files, in Pa or as fractions.

| unit | is |
|---|---|
| tsf | 2000 lb on a square foot: 95,760.518 Pa |
| ksf | 1000 lb on a square foot: 47,880.259 Pa |
| psi | 6,894.757 Pa |
| kgf/cm2, ksc | 98,066.5 Pa |
| N/cm2 | 10,000 Pa |
| in/in, mm/mm, m/m, - | 1 |
"""

PRESSURES = {
    "kPa": 1e3, "MPa": 1e6, "Pa": 1.0, "bar": 1e5, "psi": 6894.757, "tsf": 95760.518, "ksf": 47880.259,
    "kgf/cm2": 98066.5, "ksc": 98066.5, "N/cm2": 1e4, "kN/m2": 1e3,
}  # fmt: skip
FRACTIONS = {"%": 0.01, "-": 1.0, "mm/mm": 1.0, "in/in": 1.0, "permille": 0.001}
