"""The HTML report of a run, with the settings of its case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from supple.cases.case import Case
from supple.cases.existing_results import readings_paths, report_path
from supple.fem import FiniteElementModel
from supple.integrate import Solution, StepProgress
from supple.machine import System
from supple.mesh import Mesh
from supple.quantities import Reading, TrackedMotion
from supple.storage.run_inputs import FILE, Inputs

__all__ = [
    "case_texts",
    "coloured_elements",
    "page_looks",
    "page_path",
    "write_run_page",
    "written_after_the_run",
]


def page_path(folder: Path) -> Path:
    """The file of the report of a run."""
    return folder / "report.html"


def written_after_the_run(case: Case, folder: Path) -> tuple[Path, ...]:
    """The files of numbers that the run of a case writes when it is complete."""
    readings = readings_paths(folder) if case.tables.sensor else ()
    page = (page_path(folder),) if case.tables.output.report else ()
    return report_path(case, folder), *readings, *page


def page_looks(case: Case) -> Mapping[str, Mesh | FiniteElementModel]:
    """Geometry of the bodies in the report, as in pictures, but with lines for beams of unknown section."""
    return {**case.meshes, **{name: look for name, look in case.drawn.items() if look is not None}}


def coloured_elements(case: Case, system: System) -> Mapping[str, FiniteElementModel] | None:
    """Elements whose stress colours the bodies; None unless the case selects it or a body has no frame."""
    framed = all(placed.body.has_frame for placed in system.bodies)
    return case.elements if case.tables.output.colour == "von-mises" or not framed else None


def write_run_page(
    case: Case,
    folder: Path,
    system: System,
    solution: Solution,
    *,
    tracked: Mapping[str, TrackedMotion],
    readings: Sequence[Reading],
    numbers: Mapping[str, Any],
    rounds: Sequence[Mapping[str, Any]],
    inputs: Inputs,
    progress: StepProgress,
) -> None:
    """Write `report.html`, unless switched off in the case."""
    if not case.tables.output.report:
        return
    from supple.report import write_report

    progress("writing the report", 0.0)
    write_report(
        page_path(folder),
        system,
        solution,
        page_looks(case),
        title=case.title,
        tracked=tracked,
        readings=readings,
        elements=coloured_elements(case, system),
        bases=case.bases,
        numbers=numbers,
        rounds=rounds,
        inputs=case_texts(case, inputs),
        units=case.units,
    )
    progress("writing the report", 1.0)


def case_texts(case: Case, inputs: Inputs) -> dict[str, str]:
    """The text of the case file as it was read, and the digests in `inputs` of the files that it names."""
    listed = [f"{name}  {value}" for name, value in inputs.items() if name.startswith(FILE)]
    return {case.path.name: case.text} | ({"files that it names": "\n".join(listed)} if listed else {})
