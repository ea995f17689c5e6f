"""The modes of the machine of a case, about its equilibrium."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from supple.body import FullBody
from supple.cases.case import Case
from supple.cases.drawing import check_drawing
from supple.cases.implausible_units import warn_of_units
from supple.cases.notify import silent
from supple.cases.reductions import DEFAULT_ACCURACY
from supple.cases.run_files import write_numbers
from supple.cases.static_case import analysed_system, spin_of
from supple.equations.build_model import system_length
from supple.error import MotionOutsideBasis, correct_statically
from supple.errors import CaseError
from supple.integrate import Solution, StepProgress
from supple.linearization import (
    CampbellDiagram,
    LinearMachine,
    MachineModes,
    campbell_diagram,
    damping_in_space,
    effective_masses,
    linearize,
    machine_modes,
    mode_motion,
    mode_names,
    whirl,
)
from supple.linearization.linear_machine import STANDING
from supple.machine import Spin, System
from supple.results.camera import View
from supple.results.mode_tables import SENSES, mode_tables, speed_tables
from supple.results.run_summary import unit_names
from supple.simulation.equilibrium import LARGEST_ERROR
from supple.units import plain_number, with_unit

__all__ = ["campbell_case", "mode_case", "modes_case"]

AMPLITUDE = 0.1
"""Amplitude of a drawn mode, relative to the machine's size."""
NO_DEFORMATION = 1e-12
"""Static deformation, relative to the machine's size, below which its error is ignored."""


def modes_case(
    case: Case,
    folder: Path,
    *,
    n_modes: int = 6,
    time: float = 0.0,
    errors: bool = True,
    allow_code: bool = False,
    progress: StepProgress = silent,
) -> tuple[MachineModes, dict[str, Any]]:
    """Modes of a case's machine; writes `CASE-modes.json`, a page, and pictures and animations of the shapes.

    Modes with an error of 1 % or more are listed with their error, but not drawn.

    time : time at which loads and laws are evaluated
    errors : estimate the errors of the modes, relative to the machine whose bodies are not reduced
    allow_code : whether the controllers of the case may run

    Raises
    ------
    CaseError               code that fails; a drawing library that is missing; a self-correcting reduction
                            beside a body that is not reduced, or in a machine linearised in fixed axes
    SelfCorrectionError     a body that does not reach its accuracy
    ModelError              the errors of `linearize`
    ConvergenceError        no equilibrium
    """
    check_drawing(case)
    warn_of_units(case)
    progress("linearising", 0.0)
    modes = found_modes(case, n_modes, time=time, errors=errors, allow_code=allow_code)
    progress("linearising", 1.0)
    numbers: dict[str, Any] = {"title": case.title, "time": time, **_numbers(case, modes)}
    path = write_numbers(case, folder, "modes", numbers)
    if case.tables.output.report:
        from supple.report import write_modes_report

        write_modes_report(
            path.with_suffix(".html"),
            modes,
            case.page_looks,
            tables=mode_tables(numbers),
            chosen=_drawn(modes),
            title=f"{case.title}: modes",
            bases=case.bases,
            inputs=case.texts(case.inputs),
            units=case.units,
        )
    if case.tables.output.pictures or case.tables.output.animation:
        _draw(case, modes, folder, progress)
    return modes, numbers


def found_modes(case: Case, n_modes: int, *, time: float, errors: bool, allow_code: bool) -> MachineModes:
    """Modes of a case's machine; parameters and errors as for `modes_case`."""
    system, spin = analysed_system(case, time=time, allow_code=allow_code), spin_of(case)
    fulls = None if errors or case.starts else ()
    if case.starts:
        system = _accurate(case, system, (spin,), n_modes, time)
    return machine_modes(linearize(system, time=time, spin=spin, fulls=fulls), n_modes)


def mode_case(case: Case, number: int, *, time: float) -> tuple[System, Solution]:
    """A mode of a case's machine, without its controllers, as a motion; errors as for `modes_case`.

    number : from 1, in order of frequency; the motion starts at phase 0
    """
    modes = found_modes(case, number, time=time, errors=False, allow_code=False)
    system = modes.machine.system
    return system, mode_motion(modes, number - 1, amplitude=AMPLITUDE * system_length(system))


def campbell_case(
    case: Case,
    folder: Path,
    rates: Sequence[float],
    *,
    n_modes: int = 6,
    errors: bool = True,
    allow_code: bool = False,
    progress: StepProgress = silent,
) -> CampbellDiagram:
    """Modes of a case's machine at several angular velocities; writes `CASE-campbell.json`, page and picture.

    Bodies with a self-correcting reduction meet their accuracy at the first and the last rate.

    rates : angular velocities about the axis of the case's spin, rad per unit of time

    Raises CaseError if the case has no spin, and as for `modes_case`.
    """
    check_drawing(case)
    warn_of_units(case)
    spin = spin_of(case)
    if spin is None:
        raise CaseError(f"{case.path}: a Campbell diagram needs a spin; add [spin] with rate and axis")
    spins = [replace(spin, rate=float(rate)) for rate in rates]
    system = analysed_system(case, allow_code=allow_code)
    if case.starts:
        system = _accurate(case, system, (spins[0], spins[-1]), n_modes, 0.0)
    diagram = campbell_diagram(
        system,
        spins,
        n_modes=n_modes,
        fulls=None if errors or case.starts else (),
        progress=lambda share: progress("linearising", share),
    )
    numbers = {
        "title": case.title,
        "units": unit_names(case.units),
        "axes": diagram.axes,
        "rates": diagram.rates.tolist(),
        "frequencies": _shown(case, diagram.frequencies).tolist(),
        "damping_ratios": diagram.damping_ratios.tolist(),
        "damping in space": _known(damping_in_space(diagram.eigenvalues, diagram.in_space)),
        "likeness": diagram.likeness.tolist(),
        "errors": _known(diagram.errors),
        "names": list(diagram.names),
        "whirl": [[SENSES[sense] for sense in row] for row in diagram.sense.tolist()],
        "frequencies in space": _known(_shown(case, diagram.in_space)),
        "critical speeds": [
            {"rate": each.rate, "whirl": SENSES[each.sense]} for each in diagram.critical_speeds
        ],
        "unstable from": [{"rate": each.rate, "mode": diagram.names[each.mode]} for each in diagram.onsets],
    }
    path = write_numbers(case, folder, "campbell", numbers)
    if case.tables.output.report:
        from supple.report import write_campbell_report

        write_campbell_report(
            path.with_suffix(".html"),
            diagram,
            tables=list(speed_tables(diagram, case.units)),
            title=f"{case.title}: Campbell diagram",
            inputs=case.texts(case.inputs),
            units=case.units,
        )
    if case.tables.output.pictures:
        from supple.viz import plot_campbell

        plot_campbell(path.with_suffix(".png"), diagram, units=case.units)
    return diagram


def _accurate(case: Case, system: System, spins: Sequence[Spin | None], n_modes: int, time: float) -> System:
    """The machine with self-correcting bodies reduced so that its modes at all spins meet their accuracy.

    The allowed relative error of frequencies is the body's relative accuracy, or 1e-3 if its accuracy is a
    length.
    """

    def look(reduced: System, fulls: Mapping[str, FullBody]) -> dict[str, MotionOutsideBasis]:
        worst, fields = dict.fromkeys(fulls, 0.0), {name: [] for name in fulls}
        for spin in spins:
            linear = linearize(reduced, time=time, spin=spin, fulls=fulls)
            if not isinstance(linear, LinearMachine):
                raise CaseError(
                    f"{case.path}: with a body that is not reduced, no other reduction can correct itself "
                    f"for modes: give body '{next(iter(fulls))}' a basis of fixed size, or basis = \"none\""
                )
            if linear.is_in_space:
                raise CaseError(
                    f"{case.path}: the machine is linearised in fixed axes, in which no reduction corrects "
                    f"itself: give body '{next(iter(fulls))}' a basis of fixed size (remove accuracy)"
                )
            error = machine_modes(linear, n_modes).error
            if error is None or linear.full is None:
                worst = dict.fromkeys(fulls, np.inf)
                continue
            off = 1.0 if len(error.missed) else float(np.minimum(error.relative, 1.0).max(initial=0.0))
            for name, rest in linear.full.rest.items():
                at_rest = rest.rms / rest.size if rest.size > NO_DEFORMATION * system_length(system) else 0.0
                worst[name] = max(worst[name], off, at_rest)
                fields[name] += [rest.deformation[:, None], error.fields[name]]
        return {
            name: MotionOutsideBasis(
                worst[name],
                case.starts[name].target.relative or DEFAULT_ACCURACY,
                np.hstack([np.zeros((full.n_coordinates, 0)), *fields[name]]),
            )
            for name, full in fulls.items()
        }

    return correct_statically(system, case.starts, look).system


def _known(numbers: np.ndarray | None) -> Any:
    """Numbers as nested lists, with None for those that are not finite; None if there are no numbers."""
    if numbers is None:
        return None
    known = numbers.astype(object)
    known[~np.isfinite(numbers)] = None
    return known.tolist()


def _shown(case: Case, frequencies: np.ndarray) -> np.ndarray:
    """Frequencies in Hz if the unit of time is known, otherwise in cycles per unit of time."""
    return np.asarray(frequencies) / (2 * np.pi) * case.units.frequency_shown.factor


def _numbers(case: Case, modes: MachineModes) -> dict[str, Any]:
    bodies = [placed.body for placed in modes.machine.system.bodies]
    with_basis = [body.name for body in bodies if body.kind not in ("rigid", "full")]
    error, n = modes.error, len(modes.eigenvalues)
    senses, in_space = whirl(modes)
    relative = np.full(n, np.nan) if error is None else error.relative
    exact = np.full(n, np.nan) if error is None else _shown(case, error.eigenvalues.imag)
    if not with_basis:
        relative, exact = np.zeros(n), _shown(case, modes.frequencies)
    stands = modes.machine.spin is None or not modes.machine.spin.rate
    of_modes = {
        "name": mode_names(modes),
        "frequency": _shown(case, modes.frequencies).tolist(),
        "whirl": [SENSES[sense] for sense in senses.tolist()],
        "frequency in space": _known(_shown(case, in_space)),
        "damping_ratio": modes.damping_ratios.tolist(),
        "damping in space": _known(damping_in_space(modes.eigenvalues, in_space)),
        "eigenvalue": [[value.real, value.imag] for value in modes.eigenvalues],
        "error": _known(relative),
        "with all coordinates": _known(exact),
        "none of the machine's": np.isinf(relative).tolist(),
        "unstable": modes.unstable.tolist(),
        "kinetic_share": [
            dict(zip((body.name for body in bodies), share, strict=True))
            for share in modes.kinetic_shares.T.tolist()
        ],
        "effective_mass": effective_masses(modes).tolist() if stands else [None] * n,
    }
    return {
        "units": unit_names(case.units),
        "mass": sum(body.mass for body in bodies),
        "axes": modes.machine.axes,
        "periodic": modes.machine.periodic is not None,
        "bodies with a basis": with_basis,
        "missed": [] if error is None else _shown(case, error.missed.imag).tolist(),
        "modes": [dict(zip(of_modes, row, strict=True)) for row in zip(*of_modes.values(), strict=True)],
    }


def _drawn(modes: MachineModes) -> list[int]:
    """Numbers, from 0, of the modes whose shapes are drawn: those with an error below `LARGEST_ERROR`."""
    wrong = np.zeros(len(modes.eigenvalues)) if modes.error is None else modes.error.relative
    return np.flatnonzero(wrong < LARGEST_ERROR).tolist()


def _draw(case: Case, modes: MachineModes, folder: Path, progress: StepProgress) -> None:
    from supple.viz import animate_mode, draw_mode, mode_titles

    titles = mode_titles(modes.frequencies / (2 * np.pi), case.units)
    if modes.machine.axes != STANDING:
        in_space = _shown(case, whirl(modes).frequencies)
        unit = case.units.frequency_shown.unit
        titles = [
            f"{title} (in space {with_unit(plain_number(w, 4), unit)})"
            if np.isfinite(w)
            else f"{title} (turning)"
            for title, w in zip(titles, in_space, strict=True)
        ]
    output, system = case.tables.output, replace(modes.machine.system, loads=())
    nothing = np.zeros((1, modes.shapes.shape[0]))
    rest = modes.machine.motion_near(nothing, nothing)
    camera = View(output.view.camera)
    for number in _drawn(modes):
        motion = mode_motion(modes, number, amplitude=AMPLITUDE * system_length(system))
        stem, given = f"{case.path.stem}-mode-{number + 1}", (system, motion, rest, case.drawn)
        look: dict[str, Any] = {"title": titles[number], "view": camera, "units": case.units}
        if output.pictures:
            draw_mode(folder / f"{stem}.png", *given, **look)
        if output.animation:
            animate_mode(folder / f"{stem}.{output.film.format}", *given, **look)
        progress("drawing modes", (number + 1) / len(modes.eigenvalues))
