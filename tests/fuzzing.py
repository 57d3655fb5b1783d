"""Files with mistakes in them, for tests that try many: what is cut, doubled, swapped or replaced in the text of a good one."""

import os
import random
import warnings

from hypothesis import HealthCheck, settings, strategies

from graincal import InputError

CASES = int(os.environ.get("GRAINCAL_FUZZ_CASES", "300"))
"""So many files of each kind are tried."""

fuzzed = settings(max_examples=CASES, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
"""The same cases in each run."""

VALUES = [
    "0", "-1", "1", "2.5", "true", "false", '"?"', '""', '"text"', "[]", "{}", "[1]", "[[1, 2], [3]]", "inf", "-inf", "nan", "1e308", "-1e308", "5e-324", "1e400", "9223372036854775807", "9223372036854775808",
    "1000000000", "100000", "10", "100", "0.5", "1e-3", "1e10", '"volumetric_strain"', '"axial_stress"', '"hertz-mindlin"', '"iterative-bayesian"', '"posterior"', '"oedometric"', '"undrained"', '"table"', '"cubic.csv"', '"reference.csv"', "1000000000000000000", "9" * 5000, "0x" + "f" * 5000, "1." + "3" * 5000, "1979-05-27T07:32:00Z", "[" * 5000, "[" * 50 + "]" * 50, "{a = " * 30 + "1" + "}" * 30, '"a\\u0000b"', '"\\u001b[2J"', '"\\u202e"', '"' + "x" * 100_000 + '"',
    '"."', '"/"', '"/dev/null"', '"../../../.."', '["a", 1]', "{ a = 1 }", "[1e308, -1e308]", "[-1e308, 1e308]", "[0, 5e-324]", "[" + "1," * 2000 + "1]", '"os:getcwd"', '"a" # \x00',
]  # fmt: skip
PIECES = [
    "\x00",
    "\x1b[2J",
    "\u202e",
    "\ufeff",
    "\u2028",
    "é",
    "²",
    "٣",
    "\r",
    "\n",
    "\t",
    '"',
    "'",
    ",",
    ";",
    "#",
    "=",
    "-",
    "e",
    "1e400",
    "1e308",
    "nan",
    "-inf",
    "9" * 5000,
    "[" * 3000,
    "",
    " ",
    "%",
    "kPa",
    "1,234.5",
    "1.234,5",
    "−",
    "\ud83d\ude00".encode("utf-16", "surrogatepass").decode("utf-16"),
]


def mutated(text: str, seed: int) -> str:
    """The text with one to four mistakes."""
    rng = random.Random(seed)
    for _ in range(rng.randint(1, 4)):
        text = _with_a_mistake(text, rng)
    return text


def with_other_values(text: str, seed: int) -> str:
    """A file of keys with one to three other values, which leave it what TOML takes for the most part; or with mistakes as any text."""
    rng = random.Random(seed)
    if rng.random() < 0.2:
        return mutated(text, seed)
    for _ in range(rng.randint(1, 3)):
        begin = rng.choice([place + 1 for place, char in enumerate(text) if char == "="] or [0])
        text = f"{text[:begin]} {rng.choice(VALUES)} {text[_end_of_value(text, begin) :]}"
    return text


def _with_a_mistake(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    at, other, kind = rng.randrange(len(lines)), rng.randrange(len(lines)), rng.randrange(6)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(other, lines[at])
    elif kind == 2:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        place = rng.randrange(len(lines[at]) + 1)
        lines[at] = lines[at][:place] + rng.choice(PIECES) + lines[at][place + rng.randrange(3) :]
    elif kind == 4:
        lines[at] = lines[at][: rng.randrange(len(lines[at]) + 1)]
    else:
        cells = lines[at].split(",")
        cells[rng.randrange(len(cells))] = rng.choice(PIECES)
        lines[at] = ",".join(cells)
    return "\n".join(lines)


def _end_of_value(text: str, begin: int) -> int:
    """Where the value ends that begins there: at the end of its line, or of the table or list that it stands in."""
    depth, quoted = 0, False
    for place in range(begin, len(text)):
        char = text[place]
        quoted ^= char == '"'
        if not quoted and (char == "\n" or (depth == 0 and char in ",}]")):
            return place
        depth += 0 if quoted else (char in "[{") - (char in "]}")
    return len(text)


SEEDS = strategies.integers(0, 2**32)


def refused_in_words(what) -> bool:
    """Whether something is refused, by sentences in which nothing is that a terminal obeys; any other exception is a mistake of graincal's, and so is a warning of its arithmetic."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            what()
        return False
    except InputError as error:
        said = str(error)
        assert said.strip() and len(said) <= 10_000 and said.replace("\n", "").isprintable() or any(ord(char) > 126 for char in said), said
        assert "\x1b" not in said and "\x00" not in said
        return True
