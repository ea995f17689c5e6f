"""The report of a run: its numbers as a JSON file, and the picture of its self-correction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from supple.cases.case import Case
from supple.correction import Round, correction_numbers
from supple.storage import write_json


def write_report(case: Case, folder: Path, rounds: Sequence[Round], numbers: Mapping[str, Any]) -> None:
    """Write the numbers of a run; draw the rounds, if there are any and the case asks for pictures."""
    corrections = correction_numbers(rounds)
    report = {"title": case.title, "self_correction": corrections, **numbers}
    write_json(folder / f"{case.path.stem}.json", report)
    if rounds and case.tables.output.pictures:
        # Imported here: a run without pictures does not wait for the drawing library.
        from supple.viz import plot_rounds

        plot_rounds(folder / "self_correction.png", corrections)
