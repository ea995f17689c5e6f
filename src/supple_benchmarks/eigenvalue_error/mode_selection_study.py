"""The selection rules of Craig-Bampton bases on three bodies: a slender bar, a rod with two bores, a box."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from supple.body import FlexibleBody, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import box_beam
from supple_benchmarks.eigenvalue_error.mode_selection import (
    SelectionQuality,
    compare_selections,
    draw_transfer_errors,
)
from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors
from supple_benchmarks.table import Row, Table

__all__ = ["SelectionStudy", "draw_studies", "selection_studies", "selection_table", "thin_box"]

SIZES = (15, 20, 30, 40, 60, 80)
CANDIDATES = 200


@dataclass(frozen=True)
class SelectionStudy:
    """Every rule at every size, for one body.

    freedoms : degrees of freedom of the full body
    """

    body: str
    freedoms: int
    qualities: tuple[SelectionQuality, ...]

    def as_row(self) -> Row:
        """Entry of a report."""
        rules = [quality.as_row() for quality in self.qualities]
        return {"body": self.body, "freedoms": self.freedoms, "rules": rules}


def thin_box() -> FlexibleBody:
    """An aluminium box beam, 1 x 0.1 x 0.06 m, both ends rigid, with walls of 1 mm that vibrate locally."""
    section = HomogeneousSection(Isotropic(70e9, 0.33, 2700.0), 0.001)
    model = shell_model(box_beam(1.0, 0.1, 0.06, 30, 6, 4), section)
    return flexible_body("box", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])


def selection_studies(
    problem: EigenvalueErrors, sizes: Sequence[int] = SIZES, *, candidates: int = CANDIDATES
) -> Iterator[SelectionStudy]:
    """The studies of the benchmark's first cylinder and first rod, and of the thin box, one at a time."""
    first: dict[str, Callable[[], FlexibleBody]] = {}
    for case in problem.cases():
        first.setdefault(case.name, case.build)
    for name, build in [*first.items(), ("box", thin_box)]:
        body = build()
        yield SelectionStudy(name, body.n, compare_selections(body, sizes, candidates=candidates))


def selection_table(studies: Sequence[SelectionStudy]) -> Table:
    """Transfer errors: title, column heads, a row for each body and rule."""
    sizes = sorted({quality.size for study in studies for quality in study.qualities})
    rows = []
    for study in studies:
        for rule in dict.fromkeys(quality.selection for quality in study.qualities):
            errors = {q.size: q.transfer_error for q in study.qualities if q.selection == rule}
            cells = [_percent(errors[size]) if size in errors else "" for size in sizes]
            rows.append([study.body, rule, *cells])
    heads = ["body", "basis", *(f"{size}" for size in sizes)]
    return ("Error of the receptance at the interfaces, %, by number of modes kept", heads, rows)


def _percent(error: float) -> str:
    return f"{100 * error:.2g}" if error < 0.995 else f"{100 * error:.0f}"


def draw_studies(studies: Sequence[SelectionStudy], folder: Path) -> list[Path]:
    """One picture for each body; the pictures' paths."""
    folder.mkdir(parents=True, exist_ok=True)
    return [
        draw_transfer_errors(folder / f"mode_selection_{study.body}.png", study.qualities)
        for study in studies
    ]
