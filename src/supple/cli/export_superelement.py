"""Write a reduced body, from a case or from its file, for another program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from supple.arrays import FloatArray
from supple.body import RayleighDamping
from supple.cases import Case, read_case
from supple.cases.run_files import check_not_an_input
from supple.cases.static_case import assembled_system
from supple.cli.export import ExportOptions
from supple.cli.export_case import chosen_body
from supple.errors import ArgumentError, CaseError
from supple.export import (
    InterfaceForm,
    StatedFrequencies,
    blade_file_of,
    extptfm_frequencies,
    floating_frequencies,
    interface_form,
    write_abaqus_superelement,
    write_beamdyn,
    write_calculix_superelement,
    write_dmig_superelement,
    write_extptfm,
    write_exudyn,
    write_mbdyn,
    write_output4_superelement,
    write_sid,
)
from supple.importers import read_section_table
from supple.machine import GROUND, Bushing
from supple.methods.intrinsic import IntrinsicBody
from supple.reduction import ReducedBody
from supple.storage import read_reduced_body
from supple.terminal import print_table, say, shown_step

_OF_INTERFACES: dict[str, Callable[[Path, InterfaceForm], object]] = {
    ".op4": write_output4_superelement,
    ".pch": write_dmig_superelement,
    ".dmig": write_dmig_superelement,
}
_OF_BODIES: dict[str, Callable[[Path, ReducedBody], object]] = {
    ".sid": write_sid,
    ".sid_fem": write_sid,
    ".fem": write_mbdyn,
    ".npz": lambda path, body: write_exudyn(path, _linear(body)),
}
_OPENFAST, _CLOSED = ".dat", ".mnf"
_SI = ("m", "kg", "s")
_FOR_SI = (".sid", ".sid_fem")
"""Formats of Modelica, whose numbers are in SI units."""
_UPRIGHT = 1e-2
"""Largest angle, rad, between gravity and the z axis of a mesh for OpenFAST: angles may be rounded."""
_NONE = (
    "give an elastic body a reduction of fixed size; for a self-correcting one, export the NAME-reduced.h5 "
    "of its run"
)
SUPERELEMENT_SUFFIXES = (*_OF_INTERFACES, *_OF_BODIES, _OPENFAST, _CLOSED)


def export_superelement(path: Path, target: Path, options: ExportOptions) -> None:
    """Write the reduced body at `path`, a case or the file of a reduced body, in the target's format.

    A deck (.inp) has matrices for Abaqus, and equations for CalculiX.

    Raises
    ------
    ArgumentError       a closed format
    CaseError           mistakes in the case file; no such body, or several to choose from; for OpenFAST,
                        units other than m, kg and s, or a body whose mesh axis z is not upwards
    ModelError          contents that the format cannot have
    ResultFileError     a file that cannot be read or written
    """
    suffix = target.suffix.lower()
    if suffix == _CLOSED:
        raise ArgumentError(
            f"cannot write {target}: MNF is a closed format of Adams; write .op4 or .pch for a program that "
            "writes MNF, such as Nastran"
        )
    with shown_step("reading") as notify:
        if path.suffix.lower() != ".toml":
            only = read_reduced_body(path)
            if options.body and list(options.body) != [only.name]:
                raise ArgumentError(f"{path} contains the body '{only.name}' alone: remove --body")
            _write(target, suffix, only, None, abaqus=options.abaqus)
            return
        case = read_case(path, notify)
        check_not_an_input(case, [target])
        if suffix == _OPENFAST:
            check_not_an_input(case, [blade_file_of(target)])
            _check_si(case)
        reduced = case.system.bodies_of(ReducedBody)
        lines = case.system.bodies_of(IntrinsicBody) if suffix == _OPENFAST else {}
        known = [each.body.name for each in case.system.bodies if each.body.name in {*reduced, *lines}]
        name = chosen_body(case, options.body, known, "reduced bodies", _NONE)
        if name in lines:
            _write_blade(target, case, lines[name])
        else:
            _write(target, suffix, reduced[name], case, abaqus=options.abaqus)
        _print_units(case, suffix)


def _write(target: Path, suffix: str, body: ReducedBody, case: Case | None, *, abaqus: bool) -> None:
    """Write a reduced body, and print its frequencies for comparison with the other program."""
    if suffix in _OF_BODIES:
        _OF_BODIES[suffix](target, body)
        _report(target, body, floating_frequencies(body), linear=suffix not in (".sid", ".sid_fem"))
        return
    form = interface_form(body)
    stated = form.stated_frequencies()
    if suffix in _OF_INTERFACES:
        _OF_INTERFACES[suffix](target, form)
    elif suffix == _OPENFAST:
        if case is None:
            raise ArgumentError("give the case file for .dat: its joints to the ground fix the superelement")
        (free, springs), gravity = _supports(case, form), _downwards(case, body.name)
        write_extptfm(target, form, free, gravity=gravity, springs=springs)
        if springs:
            stated.append(extptfm_frequencies(form, free, springs))
    else:
        (write_abaqus_superelement if abaqus else write_calculix_superelement)(target, form)
    _report(target, body, stated, linear=True)


def _report(target: Path, body: ReducedBody, stated: StatedFrequencies, *, linear: bool) -> None:
    rows = [(words, _listed(values)) for words, values in stated]
    print_table(f"Frequencies of {body.name} for comparison", ["support", "cycles per unit of time"], rows)
    if linear and not body.is_linear:
        say("only the linear part was written: this format has no nonlinear strains")
    say(f"written to {target}")


def _print_units(case: Case, suffix: str) -> None:
    """Print the units of the numbers in a file, which none of the formats states."""
    given = _given_units(case)
    if any(given):
        expected = f"; Modelica reads {', '.join(_SI)}" if suffix in _FOR_SI and given != _SI else ""
        say(f"the numbers have the units of the case: {', '.join(given)}{expected}")


def _given_units(case: Case) -> tuple[str, str, str]:
    return case.units.length, case.units.mass, case.units.time


def _write_blade(target: Path, case: Case, body: IntrinsicBody) -> None:
    table = next(one for one in case.tables.body if one.name == body.name)
    if table.section_table is None:
        raise CaseError(
            f"{case.path}: body '{body.name}' has no section table for BeamDyn; reduce it in a floating "
            "frame for ExtPtfm"
        )
    held, values = body.stated_frequencies()
    title = f"{body.name}: frequencies for comparison, {held}, cycles per unit of time: {_listed(values)}"
    damping = body.damping
    by_strain = isinstance(damping, RayleighDamping) and damping.alpha == 0
    primary, blade = write_beamdyn(
        target,
        read_section_table(case.folder / table.section_table),
        title=[title],
        beta=damping.beta if by_strain else 0.0,
    )
    say(title)
    if damping is not None and not by_strain:
        say("no damping was written: BeamDyn takes that of kind 'rayleigh' with alpha = 0")
    say(f"written to {primary} and {blade}")


def _check_si(case: Case) -> None:
    """CaseError for a case in other units than m, kg and s, which OpenFAST reads."""
    given = _given_units(case)
    if any(given) and given != _SI:
        raise CaseError(
            f"{case.path}: the units of the case are {', '.join(given)}, and OpenFAST reads "
            f"{', '.join(_SI)}: give mesh and case in these units"
        )


def _downwards(case: Case, name: str) -> NDArray[np.float64]:
    """Gravity in the axes of the body's mesh, in which the matrices are; CaseError unless it is along -z."""
    gravity = np.asarray(case.tables.gravity) @ assembled_system(case).placed(name).rotation
    if np.hypot(*gravity[:2]) > _UPRIGHT * np.linalg.norm(gravity) or gravity[2] > 0:
        raise CaseError(
            f"{case.path}: gravity is along ({_listed(gravity)}) in the mesh axes of body '{name}', and "
            "ExtPtfm needs z upwards: rotate the mesh so that its z axis points upwards, and remove the "
            f"rotation of the body{_for_beamdyn(case, name)}"
        )
    return gravity


def _supports(case: Case, form: InterfaceForm) -> tuple[str, dict[str, tuple[FloatArray, FloatArray]]]:
    """The interface for the tower, and stiffness and damping of bushings to the ground at others, mesh axes.

    It is the one interface without a joint or a bushing to the ground.
    """
    ends = {(joint.first, joint.second) for joint in case.tables.joint}
    held = {other for pair in ends for end, other in (pair, pair[::-1]) if end == "ground"}
    loose = [name for name in form.interfaces if f"{form.name}.{name}" not in held]
    springs: dict[str, tuple[FloatArray, FloatArray]] = {}
    rotation = assembled_system(case).placed(form.name).rotation
    for bushing in case.system.loads:
        if not isinstance(bushing, Bushing) or GROUND not in (bushing.first, bushing.second):
            continue
        end = bushing.first if bushing.second == GROUND else bushing.second
        if end.body != form.name or end.interface not in loose:
            continue
        if bushing.offset is not None:
            raise CaseError(
                f"{case.path}: the bushing at '{end}' has an offset, and ExtPtfm takes no preload of "
                "springs: remove the offset"
            )
        turn = block_diag(*[rotation.T @ bushing.initial_axes] * 2)
        k, c = (turn @ np.asarray(matrix) @ turn.T for matrix in (bushing.stiffness, bushing.damping))
        stiffness, damping = springs.get(end.interface, (0.0, 0.0))
        springs[end.interface] = (stiffness + k, damping + c)
    # A bushing at the only loose interface takes the place of the tower.
    free = [name for name in loose if name not in springs] or loose
    if len(free) != 1:
        raise CaseError(
            f"{case.path}: {len(free)} interfaces of '{form.name}' are not joined to the ground "
            f"({', '.join(free) or 'none'}); ExtPtfm needs exactly one such interface. It fixes those with a "
            "joint to the ground; springs of the soil are elements of kind 'bushing' to the ground"
            f"{_for_beamdyn(case, form.name)}"
        )
    springs.pop(free[0], None)
    return free[0], springs


def _for_beamdyn(case: Case, name: str) -> str:
    """The remedy for a blade that was not meant for ExtPtfm."""
    table = next(one for one in case.tables.body if one.name == name)
    return (
        "" if table.section_table is None else "; for BeamDyn give the body condense, not frame and reduction"
    )


def _linear(body: ReducedBody) -> ReducedBody:
    return replace(body, cubic=None, quartic=None, damping_cubic=None, damping_quartic=None, condensed=None)


def _listed(values: NDArray[np.float64]) -> str:
    return ", ".join(f"{value:.6g}" for value in values) or "none"
