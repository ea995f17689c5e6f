"""Write the static problem of a case's body as an Abaqus or CalculiX deck."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from supple.cases import read_case
from supple.cases.outputs import check_not_an_input
from supple.cli.chosen_body import chosen_body
from supple.errors import CaseError
from supple.export import ABAQUS, CALCULIX, resultant, static_load, write_static_deck
from supple.terminal import console, print_rows, say, worded
from supple.units import headed, with_unit


def export_case(
    path: Path, target: Path, *, body: Sequence[str] | None, time: float | None, abaqus: bool
) -> None:
    """Write a body of the case at `path`, clamped at its joints, under its loads at one time.

    The deck contains no springs, force elements, ties or contacts of the case.

    body : name of one body; by default the only one with elements
    abaqus : three-node shells for Abaqus, instead of the six-node ones for CalculiX
    time : time at which the loads are evaluated; by default the end of the run

    Raises
    ------
    CaseError           mistakes in the case file; no such body, or several to choose from; a body without
                        joints
    ModelError          contents that a deck cannot have
    ResultFileError     a file that cannot be written
    """
    with console.status("reading") as status:
        case = read_case(path, lambda step, detail="": status.update(worded(step, detail)))
        check_not_an_input(case, [target])
        known = [one.name for one in case.tables.body if one.name in case.elements and one.explicit is None]
        name = chosen_body(
            case,
            body,
            known,
            "bodies with elements",
            "only bodies with a mesh that are not explicit can be exported",
        )
        flexible, model = case.flexible[name], case.elements[name]
        table = next(one for one in case.tables.body if one.name == name)
        instant = case.run.start + case.run.duration if time is None else time
        loads = [
            load.build(case.folder, case.place, case.meshes)
            for load in case.tables.load
            if getattr(load, "at", name).partition(".")[0] == name
        ]
        nodal = static_load(
            flexible, loads, time=instant, rotation=table.rotation, gravity=case.tables.gravity
        )
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
        program = ABAQUS if abaqus else CALCULIX
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
    say(f"written to {target} for {program.name}")


def _numbers(values: np.ndarray) -> str:
    return "  ".join(f"{value:.6g}" for value in values)
