"""What studies have to run, and what they skip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from graincal.studies.settings import Setup
from graincal.studies.study import Case, Done, Study
from graincal.studies.work import Work


@dataclass(frozen=True)
class Plan:
    """What is left. of_study: the work of each study, by its name, of which pieces that several share are named in each; skipped: (study, case) that
    lack a file; after: by the name of a piece of work what must be at its end before.
    """

    of_study: Mapping[str, tuple[Work, ...]]
    skipped: tuple[tuple[str, Case], ...]
    after: Mapping[str, tuple[Work, ...]] = field(default_factory=dict)

    @classmethod
    def of(cls, studies: Sequence[Study], setup: Setup, done: Done) -> Plan:
        work, skipped = {}, []
        after: dict[str, tuple[Work, ...]] = {}
        by_name: dict[str, Work] = {}
        for study in studies:
            cases = study.cases(setup, done)
            skipped += [(study.name, case) for case in cases if case.missing]
            after |= {each.name: case.after for case in cases for each in case.work}
            # The same name is the same work: one object of it, for a packing may have to be prepared.
            work[study.name] = tuple(dict.fromkeys(by_name.setdefault(each.name, each) for case in cases for each in (*case.after, *case.work)))
        return cls(work, tuple(skipped), after)

    def skipped_of(self, study: str) -> dict[str, list[str]]:
        """The settings that a study skips, by what they lack."""
        found: dict[str, list[str]] = {}
        for name, case in self.skipped:
            if name == study:
                found.setdefault(case.missing, []).append(case.setting)
        return found

    @property
    def all(self) -> tuple[Work, ...]:
        """Each piece once."""
        return tuple(dict.fromkeys(each for work in self.of_study.values() for each in work))
