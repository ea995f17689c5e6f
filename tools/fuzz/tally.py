"""Counts of outcomes by kind of file, and the first faults of each place; kept in a file between sessions."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from worker import Finding, Outcome

SHOWN = 5
"""Largest number of listed faults with the same place in the sources."""


@dataclass
class Tally:
    """Outcomes of the mutations from number `first` on, of each kind.

    counts : by kind and outcome
    faults : list of dict       kind, number, outcome, message, where
    """

    first: int = 0
    counts: dict[str, Counter[str]] = field(default_factory=dict)
    faults: list[dict[str, Any]] = field(default_factory=list)
    seconds: float = 0.0

    @classmethod
    def kept(cls, path: Path | None, first: int) -> Self:
        """The tally in a file, or a new one."""
        if path is None or not path.exists():
            return cls(first)
        known = json.loads(path.read_text(encoding="utf-8"))
        if known["first"] != first:
            raise SystemExit(f"{path} began with mutation {known['first']}, not {first}")
        known["counts"] = {kind: Counter(counts) for kind, counts in known["counts"].items()}
        return cls(**known)

    def keep(self, path: Path | None) -> None:
        """Write the tally to a file, completely or not at all."""
        if path is not None:
            part = path.with_name(f"{path.name}.part")
            part.write_text(json.dumps(vars(self), indent=1) + "\n", encoding="utf-8")
            part.replace(path)

    def count(self, kind: str, number: int, finding: Finding) -> None:
        """Count a finding, and list it if it is one of the first faults of its place."""
        self.counts.setdefault(kind, Counter())[finding.outcome] += 1
        if finding.outcome.is_fault:
            alike = [each for each in self.faults if (each["kind"], each["where"]) == (kind, finding.where)]
            if len(alike) < SHOWN:
                self.faults.append({"kind": kind, "number": number, **finding._asdict()})

    def take_back(self) -> list[tuple[str, int]]:
        """Remove the listed faults from the counts; their kinds and numbers, to be tried again."""
        listed, self.faults = self.faults, []
        for fault in listed:
            self.counts[fault["kind"]][fault["outcome"]] -= 1
        return [(fault["kind"], fault["number"]) for fault in listed]

    def next(self, kind: str) -> int:
        """Number of the next mutation of a kind."""
        return self.first + sum(self.counts.get(kind, Counter()).values())

    def line(self, kind: str) -> str:
        """The counts of a kind in words."""
        counts = self.counts[kind]
        return f"{kind:<18} " + ", ".join(f"{counts[each]} {each}" for each in Outcome if counts[each])

    @property
    def n_mutations(self) -> int:
        """Of all kinds."""
        return sum(sum(counts.values()) for counts in self.counts.values())

    @property
    def n_faults(self) -> int:
        """Of all kinds."""
        return sum(counts[each] for counts in self.counts.values() for each in Outcome if each.is_fault)
