"""The commands `supple benchmark quadruple-pendulum` and `supple benchmark slider-crank`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

if TYPE_CHECKING:
    from supple_benchmarks.machines.quadruple_pendulum import QuadruplePendulum
    from supple_benchmarks.machines.slider_crank import SliderCrank

__all__ = ["quadruple_pendulum", "slider_crank"]


class Element(StrEnum):
    """Types of tetrahedra for a machine's flexible body."""

    TET4 = "tet4"
    TET10 = "tet10"

    @property
    def cell_type_name(self) -> str:
        """Name of the CellType."""
        return f"TETRA{self.value.removeprefix('tet')}"


MachineElement = Annotated[Element, typer.Option(help="Elements of the flexible body; --quick uses tet4.")]
MachineQuick = Annotated[
    bool, typer.Option("--quick", help="Coarse mesh, two tolerances, short time: under a minute.")
]


def quadruple_pendulum(
    quick: MachineQuick = False,
    element: MachineElement = Element.TET10,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures and motions.")] = Path(
        "results/quadruple-pendulum"
    ),
    debug: Debug = False,
) -> None:
    """Release the pendulum of [Han2020] section 5.1, its last link reduced to three tolerances."""
    # Imported here: the solvers take seconds to load, which the help does not need.
    from supple_benchmarks.machines.quadruple_pendulum import QuadruplePendulum

    _perform(QuadruplePendulum, quick, element, json, output, debug)


def slider_crank(
    quick: MachineQuick = False,
    element: MachineElement = Element.TET10,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures and motions.")] = Path(
        "results/slider-crank"
    ),
    debug: Debug = False,
) -> None:
    """Drive the slider-crank of [Han2020] section 5.2, its rod reduced to three tolerances."""
    from supple_benchmarks.machines.slider_crank import SliderCrank

    _perform(SliderCrank, quick, element, json, output, debug)


def _perform(
    problem: type[QuadruplePendulum] | type[SliderCrank],
    quick: bool,
    element: Element,
    json: Path | None,
    output: Path,
    debug: bool,
) -> None:
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple.mesh import CellType
    from supple_benchmarks.machines.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        size = problem.quick() if quick else problem(cell_type=CellType[element.cell_type_name])
        perform(size.machine(), size.tolerances, json, output)
