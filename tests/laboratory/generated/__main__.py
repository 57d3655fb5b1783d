"""Write the generated files for inspection, or read them."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .cases import Case, cases


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.laboratory.generated", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, help="write all files and expectations.json here")
    parser.add_argument("--case", type=int, metavar="NUMBER", help="show one case and its outcome")
    parser.add_argument("--run", action="store_true", help="read all of them, and count the outcomes")
    asked = parser.parse_args()
    if asked.folder:
        write(asked.folder)
    if asked.case is not None:
        show(cases()[asked.case])
    if asked.run:
        run()


def write(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for case in cases():
        case.write(folder)
    (folder / "expectations.json").write_text(json.dumps([described(case) for case in cases()], indent=1, ensure_ascii=False), encoding="utf-8")
    print(f"{len(cases())} files and expectations.json written to {folder}.")


def described(case: Case) -> dict[str, Any]:
    figures = asdict(case)
    del figures["content"]
    return figures


def show(case: Case) -> None:
    print(case.title, "\n", *(f"{factor} = {level}; " for factor, level in case.choice.items()))
    print(f"\n--- {case.file} ({case.encoding})\n{case.content.decode(case.encoding)}")
    print("--- init is told:", " ".join(case.options) or "nothing", f"(packing of a void ratio of {case.void_ratio:g})")
    print("--- to be asked; the maker knows:" if case.wanted is None else "--- right:", json.dumps(asdict(case.truth), indent=1))
    with tempfile.TemporaryDirectory() as folder:
        outcome = case.outcome(Path(folder))
    print(f"--- {outcome.verdict}: {outcome.why}\n{json.dumps(outcome.said, indent=1, ensure_ascii=False)}")


def run() -> None:
    counted: Counter[tuple[str, str, str]] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for case in cases():
            outcome = case.outcome(Path(folder))
            counted[case.group, case.name, outcome.verdict] += 1
            print(" ".join(f"{case.title}: {outcome.verdict} {outcome.why}".split())[:400])
    for (group, name, verdict), number in sorted(counted.items()):
        print(f"{group:10} {name:40} {verdict:8} {number}")


if __name__ == "__main__":
    main()
