"""Pictures and animation of a run, drawn in this process or in another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from supple.cases.case import Case
from supple.cases.notify import silent
from supple.cases.output import Output
from supple.errors import CaseError, ModelError
from supple.fem import FiniteElementModel
from supple.integrate import Solution, StepProgress
from supple.machine import At, System
from supple.mesh import Mesh
from supple.quantities import TrackedMotion
from supple.reduction import BodyModes, ReducedBody
from supple.results.film import film_rows
from supple.units import UnitSystem

ROUNDS_PICTURE = "self_correction.png"


@dataclass(frozen=True, eq=False)
class Drawing:
    """Pictures and an animation of a run; fields as for `draw_run`.

    output : of the case, which selects what is drawn, and how
    rounds : rounds of a self-correction, from `correction_numbers`; drawn with the pictures if there are any
    """

    folder: Path
    system: System
    solution: Solution
    meshes: Mapping[str, Mesh | FiniteElementModel | None]
    tracked: Mapping[str, TrackedMotion]
    modes: Mapping[str, BodyModes]
    elements: Mapping[str, FiniteElementModel] | None
    bases: Mapping[str, At]
    units: UnitSystem
    output: Output
    rounds: Sequence[Mapping[str, Any]] = ()

    def draw(self, progress: StepProgress = silent) -> None:
        """Draw the pictures and the animation into the folder."""
        # Imported here: a run without pictures need not load the drawing library.
        from supple.results.colouring import PLASTIC_STRAIN
        from supple.viz import animate_run, draw_run, plot_rounds

        run, output = (self.system, self.solution, self.meshes), self.output
        if output.pictures:
            progress("drawing pictures", 0.0)
            draw_run(
                self.folder,
                *run,
                tracked=self.tracked,
                modes=self.modes,
                elements=self.elements,
                bases=self.bases,
                view=output.view,
                units=self.units,
            )
            if self.rounds:
                plot_rounds(self.folder / ROUNDS_PICTURE, self.rounds, units=self.units)
            progress("drawing pictures", 1.0)
        if output.animation:
            animate_run(
                self.folder / f"motion.{output.film.format}",
                *run,
                elements=self.elements,
                colouring=PLASTIC_STRAIN if output.colour == "plastic-strain" else None,
                bases=self.bases,
                film=output.film.build(),
                view=output.view,
                units=self.units,
                progress=lambda share: progress("drawing the animation", share),
            )


def check_drawing(case: Case) -> None:
    """Raise CaseError, before any computation, if a library is missing or the animation has no frames."""
    output = case.tables.output
    if not (output.pictures or output.animation):
        return
    missing = [name for name in ("matplotlib", "PIL") if find_spec(name) is None]
    if missing:
        raise CaseError(
            f"{case.path}: pictures need {' and '.join(missing)}, not installed here: "
            "pip install 'supple[plot]', or give pictures = false and animation = false in [output]"
        )
    if output.animation and output.film.format == "mp4" and find_spec("imageio_ffmpeg") is None:
        raise CaseError(
            f"{case.path}: an MP4 needs imageio-ffmpeg, not installed here: pip install 'supple[film]', "
            'or give format = "gif" in film of [output]'
        )
    if output.animation:
        film = output.film.build()
        try:
            film_rows(replace(film, at=None), case.run.times, film.frames_per_second)
        except ModelError as error:
            raise CaseError(f"{case.path}: [output] film: {error}") from error


def drawing_of(
    case: Case,
    system: System,
    solution: Solution,
    tracked: Mapping[str, TrackedMotion],
    folder: Path,
    rounds: Sequence[Mapping[str, Any]],
) -> Drawing | None:
    """The drawings selected by a case; None if there are none."""
    output = case.tables.output
    if not (output.pictures or output.animation):
        return None
    return Drawing(
        folder,
        system,
        solution,
        case.drawn,
        tracked,
        case.held_modes if output.pictures and system.bodies_of(ReducedBody) else {},
        case.coloured_elements(system),
        case.bases,
        case.units,
        output,
        rounds,
    )
