"""Parts, instances and steps: the scope of names of each keyword."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.importers.abaqus.report import Report
from supple.importers.keyword_file import KeywordBlock, KeywordFile, fields, numbers


@dataclass(frozen=True, eq=False)
class Scope:
    """Scope of names and ids: an instance, or the model outside all instances.

    rotation, shift : (3, 3), (3,)   a point x of the part is placed at `rotation @ x + shift`
    """

    name: str = ""
    rotation: FloatArray = field(default_factory=lambda: np.eye(3))
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, eq=False)
class ScopedBlock:
    """A keyword in scope number `scope` (0: the model), in step `step` (0: outside of steps)."""

    scope: int
    step: int
    block: KeywordBlock


def scoped_blocks(file: KeywordFile, report: Report) -> tuple[tuple[Scope, ...], tuple[ScopedBlock, ...]]:
    """The scopes of a file, and its keywords in order; keywords of a part once for each of its instances.

    In a file without instances, each part is a scope, and the keywords of parts come last.

    Raises
    ------
    ImportFormatError   an instance of an unknown part; words instead of numbers; a rotation without two
                        different points and an angle
    """
    parts, rest = _parts(file)
    scopes, found = [Scope()], list[ScopedBlock]()
    used: set[str] = set()
    scope = step = 0
    inside_step = False
    for block in rest:
        if block.key == "INSTANCE":
            scopes.append(_instance(file, block))
            scope = len(scopes) - 1
            name = block.options.get("PART", "").upper()
            if name in parts:
                found += [ScopedBlock(scope, 0, inside) for inside in parts[name][1]]
                used.add(name)
            elif "LIBRARY" in block.options:
                report.leave_out_block(block, "this instance of another analysis is not read")
            elif parts:
                raise file.error(
                    block.line, f"an instance of part '{name}', which the file does not define; add the part"
                )
        elif block.key == "ENDINSTANCE":
            scope = 0
        else:
            if block.key == "STEP":
                step, inside_step = step + 1, True
            found.append(ScopedBlock(scope, step if inside_step else 0, block))
            inside_step = inside_step and block.key != "ENDSTEP"
    alone = len(scopes) == 1
    for key, (name, blocks) in parts.items():
        if alone:
            scopes.append(Scope(name))
            found += [ScopedBlock(len(scopes) - 1, 0, inside) for inside in blocks]
        elif key not in used:
            report.note(f"part '{name}' has no instance and is not read")
    return tuple(scopes), tuple(found)


def _parts(file: KeywordFile) -> tuple[dict[str, tuple[str, list[KeywordBlock]]], list[KeywordBlock]]:
    """Name and keywords of each part by its name in upper case, and the keywords outside of parts."""
    parts: dict[str, tuple[str, list[KeywordBlock]]] = {}
    part: list[KeywordBlock] | None = None
    rest: list[KeywordBlock] = []
    for block in file.blocks:
        if block.key == "PART":
            name = block.options.get("NAME", "")
            part = parts.setdefault(name.upper(), (name, []))[1]
        elif block.key == "ENDPART":
            part = None
        else:
            (rest if part is None else part).append(block)
    return parts, rest


def _instance(file: KeywordFile, block: KeywordBlock) -> Scope:
    """The scope of an instance: translated by data line 1, then rotated about the axis on data line 2."""
    given = block.placed_data
    rows = [numbers(file, line, fields(text)) for line, text in given]
    name = block.options.get("NAME", "")
    shift = np.array([*(rows[0] if rows else []), 0.0, 0.0, 0.0][:3])
    if len(rows) < 2:
        return Scope(name, np.eye(3), shift)
    if len(rows[1]) != 7 or rows[1][:3] == rows[1][3:6]:
        raise file.error(
            given[1][0],
            "an instance rotates about the line through two points, by an angle in degrees: give 7 numbers, "
            "with two different points",
        )
    start, end, angle = np.array(rows[1][:3]), np.array(rows[1][3:6]), rows[1][6]
    axis = (end - start) / np.linalg.norm(end - start)
    rotation = Rotation.from_rotvec(np.radians(angle) * axis).as_matrix()
    return Scope(name, rotation, rotation @ (shift - start) + start)
