"""Write the static problem of a case's body as an Abaqus or CalculiX deck; choice of the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from supple.cases import Case, read_case
from supple.cases.run_files import check_not_an_input
from supple.cases.static_case import assembled_system
from supple.cli.export import ExportOptions
from supple.errors import ArgumentError, CaseError, did_you_mean
from supple.export import ABAQUS, CALCULIX, TABLE_SUFFIXES, resultant, static_load, write_static_deck
from supple.importers.toml import CheckedTable
from supple.terminal import print_rows, say, shown_step
from supple.units import headed, with_unit


def export_case(path: Path, target: Path, options: ExportOptions) -> None:
    """Write a body of the case at `path`, clamped at its joints, under its loads at one time.

    The orientation of the body is that of the case, after assembly if the case requests it. A split body is
    written as a whole. The deck contains no springs, force elements, ties, contacts, controllers or rotation
    of the case; a line states which of them act on the body.

    The shells have three nodes for Abaqus, and six for CalculiX.

    Raises
    ------
    ArgumentError       a target that is a table or a picture
    CaseError           mistakes in the case file; no such body, or several to choose from; a body without
                        joints
    ModelError          contents that a deck cannot have
    ConvergenceError    joints that cannot be closed
    ResultFileError     a file that cannot be written
    """
    if target.suffix.lower() in (".vtu", ".vtkhdf", *TABLE_SUFFIXES):
        raise ArgumentError(
            f"cannot write {target} from a case: tables and pictures of a run are written from its result "
            "(.h5). Run the case, then export the result"
        )
    with shown_step("reading") as notify:
        case = _undivided(read_case(path, notify))
        check_not_an_input(case, [target])
        known = [one.name for one in case.tables.body if one.name in case.elements and one.explicit is None]
        name = chosen_body(
            case,
            options.body,
            known,
            "bodies with elements",
            "only bodies with a mesh that are not explicit can be exported",
        )
        flexible, model = case.flexible[name], case.elements[name]
        table = next(one for one in case.tables.body if one.name == name)
        instant = case.run.start + case.run.duration if options.time is None else options.time
        loads = [
            load.build(case.folder, case.place, case.pressed)
            for load in case.tables.load
            if getattr(load, "at", name).partition(".")[0] == name
        ]
        rotation = table.rotation
        if case.tables.simulation.assemble:
            turn = assembled_system(case).placed(name).rotation
            rotation = Rotation.from_matrix(turn).as_rotvec()
        nodal = static_load(flexible, loads, time=instant, rotation=rotation, gravity=case.tables.gravity)
        held = {
            place
            for joint in case.tables.joint
            for owner, _, place in (joint.first.partition("."), joint.second.partition("."))
            if owner == name
        }
        interfaces = sorted(held)
        clamped = [np.asarray(flexible.interface(place).node_ids) for place in interfaces]
        if not clamped:
            raise CaseError(
                f"{path}: no joint constrains body '{name}', so it has no static equilibrium: add a joint"
            )
        program = ABAQUS if options.abaqus else CALCULIX
        write_static_deck(
            target, model, nodal, np.concatenate(clamped), program=program, title=case.title or name
        )
    total = resultant(model, nodal)
    print_rows(
        f"Static problem of {name}",
        [
            ("nodes, elements", f"{model.mesh.n_nodes}, {sum(map(len, model.mesh.cells.values()))}"),
            ("clamped", ", ".join(interfaces)),
            ("loads at", with_unit(f"t = {instant:g}", case.units.time)),
            (headed("sum of forces", case.units.force), _numbers(total[:3])),
            (headed("moment about the mesh's origin", case.units.moment), _numbers(total[3:])),
        ],
    )
    if left_out := _left_out(case, name):
        say(f"without the case's {left_out}: the deflections differ from those of the case")
    say(f"written to {target} for {program.name}")


def _undivided(case: Case) -> Case:
    """The case without splits: a deck has the elements of the whole body, whatever its frames are."""
    if all(body.split is None for body in case.tables.body):
        return case
    bodies = tuple(body.model_copy(update={"split": None}) for body in case.tables.body)
    return replace(case, tables=case.tables.model_copy(update={"body": bodies}))


def _left_out(case: Case, name: str) -> str:
    """What acts on a body in the case and is not in its deck, for messages; empty if there is nothing."""
    tables = case.tables
    kinds = {
        "springs": tables.spring,
        "force elements": tables.element,
        "ties": tables.tie,
        "contacts": tables.contact,
    }
    counts = {words: sum(_touches(each, name) for each in given) for words, given in kinds.items()}
    found = [f"{words} ({count})" for words, count in counts.items() if count]
    found += ["controllers"] if tables.control is not None else []
    found += ["steady rotation"] if tables.spin is not None else []
    return ", ".join(found)


def _touches(table: CheckedTable, name: str) -> bool:
    """Whether a spring, force element, tie or contact acts on a body."""
    ends = (getattr(table, key, None) for key in ("first", "second", "nodes", "on", "surface"))
    return any(isinstance(end, str) and end.partition(".")[0] == name for end in ends)


def _numbers(values: np.ndarray) -> str:
    return "  ".join(f"{value:.6g}" for value in values)


def chosen_body(case: Case, names: Sequence[str] | None, known: Sequence[str], kind: str, none: str) -> str:
    """The body with the given name, or the only one.

    known : bodies that can be written
    kind : description of these bodies
    none : remedy if there are no such bodies

    Raises CaseError for several names, an unknown name, the name of a split body, or no name where there are
    several bodies.
    """
    listed = ", ".join(known) or "none"
    if names and len(names) > 1:
        raise CaseError(f"{case.path}: only one body can be written, and {len(names)} are given: give one")
    if not names and len(known) == 1:
        return known[0]
    if not names:
        remedy = "give one: --body NAME" if known else none
        raise CaseError(f"{case.path} has {len(known)} {kind} ({listed}); {remedy}")
    parts = case.names_in_machine(names)
    if parts != list(names):
        raise CaseError(
            f"{case.path}: split divides body '{names[0]}' into {', '.join(parts)}; give one of these "
            "parts, or remove split"
        )
    if names[0] not in known:
        raise CaseError(
            f"{case.path}: '{names[0]}' is none of the {kind}{did_you_mean(names[0], list(known))}"
        )
    return names[0]
