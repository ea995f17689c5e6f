"""Read mutated files of every kind: each is read or refused in words, or a fault is counted.

    python tools/fuzz --quick               # about a minute; the exit code tells of faults
    python tools/fuzz -n 100000             # and writes report.json and report.md beside this file

Seeds are fixed: mutation k of a kind is the same file on every machine.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import zlib
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from corpus import Kind, kinds
from mutate import mutated
from worker import MEMORY, SECONDS, Finding, Outcome, Worker

SEED = 20261122
QUICK = 2500
FOLDER = Path(__file__).resolve().parent
SHOWN = 5
"""Faults of one place that are listed."""


def main() -> int:
    """Run; the exit code is 1 where a reader failed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} mutations and no report")
    parser.add_argument("-n", type=int, default=100_000, help="mutations, shared evenly between the kinds")
    parser.add_argument("--only", help="one kind, by its label")
    parser.add_argument("--keep", type=Path, help="folder for the files that a reader failed on")
    parser.add_argument("--first", type=int, default=0, help="number of the first mutation")
    given = parser.parse_args()
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        chosen = [kind for kind in kinds(Path(folder)) if given.only in (None, kind.label)]
        if given.quick:
            chosen = [kind for kind in chosen if not kind.is_hdf5]
        each = -(-(QUICK if given.quick else given.n) // len(chosen))
        counts, faults = {}, []
        for kind in chosen:
            counts[kind.label], found = _tried(
                kind, Path(folder), range(given.first, given.first + each), given.keep
            )
            faults += found
            line = ", ".join(
                f"{counts[kind.label][each]} {each}" for each in Outcome if counts[kind.label][each]
            )
            print(f"{kind.label:<18} {line}", flush=True)
    seconds = time.perf_counter() - began
    for fault in faults:
        print(
            f"FAULT {fault['kind']} {fault['number']}: {fault['outcome']}: {fault['message']} "
            f"({fault['where']})"
        )
    if not (given.quick or given.only):
        _write_report(counts, faults, seconds)
    total = sum(sum(each.values()) for each in counts.values())
    n_faults = sum(each[outcome] for each in counts.values() for outcome in Outcome if outcome.is_fault)
    print(f"{total} mutations in {seconds:.0f} s: {n_faults} faults")
    return int(n_faults > 0)


def _tried(
    kind: Kind, folder: Path, numbers: range, keep: Path | None
) -> tuple[Counter[Outcome], list[dict]]:
    """Counts of outcomes, and the first faults of each place."""
    counts: Counter[Outcome] = Counter()
    faults: list[dict] = []
    places: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir=folder) as own:
        worker = Worker(Path(own))
        for seed in kind.seeds:
            finding = worker.read(kind.reader, *_beside(Path(own), seed, seed.content))
            if finding.outcome is not Outcome.GOOD:
                raise SystemExit(
                    f"the seed {seed.name} of {kind.label} is {finding.outcome}: {finding.message}"
                )
        for number in numbers:
            rng = np.random.default_rng([SEED, zlib.crc32(kind.label.encode()), number])
            seed = kind.seeds[number % len(kind.seeds)]
            content = mutated(rng, seed.content, [each.content for each in kind.seeds])
            finding: Finding = worker.read(kind.reader, *_beside(Path(own), seed, content))
            counts[finding.outcome] += 1
            if finding.outcome.is_fault:
                places[finding.where] += 1
                if places[finding.where] <= SHOWN:
                    faults.append({"kind": kind.label, "number": number, **finding._asdict()})
                if keep is not None:
                    keep.mkdir(parents=True, exist_ok=True)
                    (keep / f"{kind.label.replace(' ', '-')}-{number}-{seed.name}").write_bytes(content)
        worker.end()
    return counts, faults


def _beside(folder: Path, seed, content: bytes) -> tuple[str, bytes]:
    for name, companion in seed.companions.items():
        (folder / name).write_bytes(companion)
    return seed.name, content


def _write_report(counts: dict[str, Counter[Outcome]], faults: list[dict], seconds: float) -> None:
    total = sum(sum(each.values()) for each in counts.values())
    date = datetime.now(UTC).date().isoformat()
    table = {kind: {str(outcome): found[outcome] for outcome in Outcome} for kind, found in counts.items()}
    numbers = {
        "date": date,
        "seed": SEED,
        "mutations": total,
        "seconds": round(seconds),
        "outcomes": table,
        "faults": faults,
    }
    (FOLDER / "report.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    heads = [str(outcome) for outcome in Outcome]
    lines = [
        "# Mutated files",
        "",
        f"{date}: {total} mutations of valid files, seed {SEED}, within {MEMORY / 2**30:g} GiB and "
        f"{SECONDS:g} s each. A file",
        "is read (good) or refused by an error of supple's own; all other outcomes are faults.",
        "",
        f"| kind of file | {' | '.join(heads)} |",
        f"| --- |{' --- |' * len(heads)}",
        *(f"| {kind} | {' | '.join(str(row[head]) for head in heads)} |" for kind, row in table.items()),
    ]
    (FOLDER / "report.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
