"""Read mutated files of every kind: a file must be read or rejected with a message; all else is a fault.

    python tools/fuzz --quick               # ten seconds; the exit code is 1 if a reader failed
    python tools/fuzz -n 100000             # writes report.json and report.md beside this file, too
    python tools/fuzz -n 100000 --kept F    # stores the counts in F; the same command continues from there
                                            # and tries the listed faults again

Seeds are fixed: mutation k of a kind is the same file on every machine.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import zlib
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from corpus import Kind, kinds
from mutate import mutated
from tally import Tally
from worker import MEMORY, SECONDS, WAITING, Outcome, Worker

SEED = 20261122
QUICK = 1000
BATCH = 250
"""Number of mutations of one kind before the next kind."""
FOLDER = Path(__file__).resolve().parent


def main() -> int:
    """Run; the exit code is 1 if a reader failed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} mutations and no report")
    parser.add_argument("-n", type=int, default=100_000, help="mutations, shared evenly between the kinds")
    parser.add_argument("--only", help="one kind, by its label")
    parser.add_argument("--keep", type=Path, help="folder for the files on which a reader failed")
    parser.add_argument("--kept", type=Path, help="file of the counts: created, or continued from")
    parser.add_argument("--first", type=int, default=0, help="number of the first mutation")
    given = parser.parse_args()
    tally = Tally.kept(given.kept, given.first)
    with tempfile.TemporaryDirectory() as folder:
        chosen = [kind for kind in kinds(Path(folder)) if given.only in (None, kind.label)]
        if given.quick:
            chosen = [kind for kind in chosen if not kind.is_hdf5]
        for kind in chosen:
            _check_seeds(kind, Path(folder))
        for label, number in tally.take_back():
            for kind in chosen:
                if kind.label == label:
                    _try(kind, Path(folder), range(number, number + 1), tally, given.keep)
        end = given.first + -(-(QUICK if given.quick else given.n) // len(chosen))
        while waiting := [kind for kind in chosen if tally.next(kind.label) < end]:
            for kind in waiting:
                first = tally.next(kind.label)
                _try(kind, Path(folder), range(first, min(first + BATCH, end)), tally, given.keep)
                tally.keep(given.kept)
                print(tally.line(kind.label), flush=True)
    for fault in tally.faults:
        print(
            f"FAULT {fault['kind']} {fault['number']}: {fault['outcome']}: {fault['message']} "
            f"({fault['where']})"
        )
    if not (given.quick or given.only):
        _write_report(tally)
    print(f"{tally.n_mutations} mutations in {tally.seconds:.0f} s: {tally.n_faults} faults")
    return int(tally.n_faults > 0)


def _check_seeds(kind: Kind, folder: Path) -> None:
    with tempfile.TemporaryDirectory(dir=folder) as own:
        worker = Worker(Path(own))
        for seed in kind.seeds:
            finding = worker.read(kind.reader, *_beside(Path(own), seed, seed.content))
            if finding.outcome is not Outcome.GOOD:
                raise SystemExit(
                    f"the seed {seed.name} of {kind.label} is {finding.outcome}: {finding.message}"
                )
        worker.end()


def _try(kind: Kind, folder: Path, numbers: range, tally: Tally, keep: Path | None) -> None:
    began = time.perf_counter()
    with tempfile.TemporaryDirectory(dir=folder) as own:
        worker = Worker(Path(own))
        for number in numbers:
            rng = np.random.default_rng([SEED, zlib.crc32(kind.label.encode()), number])
            seed = kind.seeds[number % len(kind.seeds)]
            content = mutated(rng, seed.content, [each.content for each in kind.seeds])
            finding = worker.read(kind.reader, *_beside(Path(own), seed, content))
            tally.count(kind.label, number, finding)
            if finding.outcome.is_fault and keep is not None:
                keep.mkdir(parents=True, exist_ok=True)
                (keep / f"{kind.label.replace(' ', '-')}-{number}-{seed.name}").write_bytes(content)
        worker.end()
    tally.seconds += time.perf_counter() - began


def _beside(folder: Path, seed, content: bytes) -> tuple[str, bytes]:
    for name, companion in seed.companions.items():
        (folder / name).write_bytes(companion)
    return seed.name, content


def _write_report(tally: Tally) -> None:
    date = datetime.now(UTC).date().isoformat()
    table = {
        kind: {str(outcome): found[outcome] for outcome in Outcome} for kind, found in tally.counts.items()
    }
    numbers = {
        "date": date,
        "seed": SEED,
        "mutations": tally.n_mutations,
        "seconds": round(tally.seconds),
        "outcomes": table,
        "faults": tally.faults,
    }
    (FOLDER / "report.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    heads = [str(outcome) for outcome in Outcome]
    lines = [
        "# Mutated files",
        "",
        f"{date}: {tally.n_mutations} mutations of valid files, seed {SEED}, within {MEMORY / 2**30:g} GiB",
        f"and {SECONDS:g} s of processor time each (or {WAITING * SECONDS:g} s of wall time). A file is read",
        "(good) or rejected with an error of supple (refused); all other outcomes are faults. HDF5 files",
        "are copied (`copied_hdf5`) by a forked process instead of a new one.",
        "",
        f"| kind of file | {' | '.join(heads)} |",
        f"| --- |{' --- |' * len(heads)}",
        *(f"| {kind} | {' | '.join(str(row[head]) for head in heads)} |" for kind, row in table.items()),
    ]
    (FOLDER / "report.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
