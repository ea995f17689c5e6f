"""Every deck of a folder: whether it is read, and the errors of its mass, centre and frequencies.

`expected.json` is `{deck: {"mass", "cg", "frequencies_hz", ..}}`; unknown values are left out. Frequencies
are those with the deck's own supports, including free rigid motions. A deck that fails, or exceeds its time
limit, is one line of the table.
"""

from __future__ import annotations

import json
import multiprocessing
import warnings
from collections.abc import Iterator, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from supple.errors import ImportFormatError, SuppleError
from supple.terminal import console, words

__all__ = ["compared", "perform", "totals"]

STILL = 1e-3
"""Frequencies below this fraction of the highest one in a list are rigid motions with round-off."""

MASS_WITHIN, CENTRE_WITHIN, FREQUENCY_WITHIN = 1e-5, 1e-5, 0.02


def perform(folder: Path, report: Path, seconds: float) -> None:
    """Read the decks, print a table and write the report.

    Raises
    ------
    ImportFormatError   a folder without a valid expected.json
    """
    expected = _expected(folder / "expected.json")
    found = {}
    for name, own in _one_by_one(folder, expected, seconds):
        found[name] = own | compared(own, expected[name])
        console.print(words(f"{name}: {_line(found[name])}"))
    summary = totals(found)
    table = Table("what", "how many", title="Decks")
    for what, count in summary.items():
        table.add_row(what.replace("_", " "), str(count))
    console.print(table)
    report.parent.mkdir(parents=True, exist_ok=True)
    report.write_text(json.dumps({"decks": found, "totals": summary}, indent=1) + "\n", encoding="utf-8")


def compared(found: Mapping[str, Any], expected: Mapping[str, Any]) -> dict[str, Any]:
    """Relative errors of mass and frequencies, error of the centre over the size; unknown values are omitted.

    found : results of a deck as written by `supple info --json`, and its "size"
    """
    errors: dict[str, Any] = {}
    mass, reference = found.get("mass"), expected.get("mass")
    if mass is not None and reference is not None:
        errors["mass_error"] = abs(mass - reference) / (abs(reference) or 1.0)
        if reference and mass and "cg" in expected:
            distance = np.linalg.norm(np.subtract(found["centre"], expected["cg"]))
            errors["centre_error"] = float(distance / (found["size"] or 1.0))
    pairs = zip(_elastic(found.get("frequencies_hz")), _elastic(expected.get("frequencies_hz")), strict=False)
    apart = [abs(own - reference) / reference for own, reference in pairs]
    if apart:
        errors["frequency_errors"] = apart
    return errors


def totals(found: Mapping[str, Mapping[str, Any]]) -> dict[str, int]:
    """Number of decks read, read completely, and within the allowed errors if complete."""
    read = [own for own in found.values() if own["read"]]
    whole = [own for own in read if not own["left_out"]]

    def close(key: str, within: float) -> dict[str, int]:
        errors = [np.max(own[key]) for own in whole if key in own]
        return {f"with_{key}": len(errors), f"{key}_within": sum(bool(e <= within) for e in errors)}

    return {
        "decks": len(found),
        "read": len(read),
        "nothing_left_out": len(whole),
        **close("mass_error", MASS_WITHIN),
        **close("centre_error", CENTRE_WITHIN),
        **close("frequency_errors", FREQUENCY_WITHIN),
    }


def _elastic(frequencies: list[float] | None) -> list[float]:
    """Frequencies without those of free rigid motions."""
    given = np.array(frequencies or [], dtype=float)
    return given[given > STILL * given.max(initial=0.0)].tolist()


def _expected(path: Path) -> dict[str, dict[str, Any]]:
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        message = f"{path}: cannot be read ({error}); give a folder with expected.json"
        raise ImportFormatError(message) from None
    if not isinstance(given, dict) or not all(isinstance(each, dict) for each in given.values()):
        raise ImportFormatError(f"{path}: give one table of numbers for each deck, by its file name")
    return given


def _one_by_one(
    folder: Path, expected: Mapping[str, Mapping[str, Any]], seconds: float
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Results of each deck, from a separate process with a time limit."""
    context = multiprocessing.get_context("spawn")
    worker: Any = None
    ours: Any = None
    for name, own in expected.items():
        if worker is None:
            ours, theirs = context.Pipe()
            worker = context.Process(target=_serve, args=(theirs,), daemon=True)
            worker.start()
            ours.recv()  # the time limit of a deck does not include the imports
        ours.send((str(folder / name), len(own.get("frequencies_hz", ()))))
        try:
            found = ours.recv() if ours.poll(seconds) else None
            why = f"took longer than {seconds:g} s"
        except EOFError:
            found, why = None, "ended the process that read it"
        if found is None:
            worker.kill()
            worker.join()
            worker, found = None, {"read": False, "why": why, "left_out": []}
        yield name, found
    if worker is not None:
        ours.close()
        worker.join()


def _serve(requests: Connection) -> None:
    """Send the results of one deck after the other until the pipe closes."""
    warnings.simplefilter("ignore")
    from supple.cli.deck_report import deck_report
    from supple.importers import read_deck

    requests.send(None)
    while True:
        try:
            path, n_modes = requests.recv()
        except EOFError:
            return
        try:
            report = deck_report(read_deck(path), n_modes=n_modes, held=True)
        except SuppleError as error:
            requests.send({"read": False, "why": str(error), "left_out": []})
        except Exception as error:  # an internal error is a line of the table
            requests.send({"read": False, "why": f"{type(error).__name__}: {error}", "left_out": []})
        else:
            size = float(np.ptp(report.deck.nodes, axis=0).max()) if len(report.deck.nodes) else 0.0
            read, why = report.mass is not None, "; ".join(report.faults)
            requests.send({"read": read, "why": why, "size": size, **report.as_json()})


def _line(found: Mapping[str, Any]) -> str:
    parts = ["read" if found["read"] else "NOT READ"]
    for key in ("mass_error", "centre_error"):
        if key in found:
            parts.append(f"{key.replace('_', ' ')} {found[key]:.1e}")
    if "frequency_errors" in found:
        parts.append(f"frequencies within {100 * max(found['frequency_errors']):.2g} %")
    parts += [f"left out {each['count']} {each['card']}" for each in found["left_out"]]
    return "; ".join([*parts, found["why"]] if found["why"] else parts)
