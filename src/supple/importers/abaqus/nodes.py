"""Nodes of an Abaqus or CalculiX file: written, generated, and moved with their instance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray, IntArray
from supple.importers.abaqus.assembly import Scope, ScopedBlock
from supple.importers.keyword_file import KeywordBlock, KeywordFile, fields, numbered_points, numbers
from supple.importers.numbering import positions_of_ids
from supple.importers.plain_number import is_plain_digits

NODE_KEYWORDS = ("NODE", "NGEN", "NFILL", "NCOPY", "SYSTEM")
"""Keywords that `read_nodes` reads; *NMAP raises ImportFormatError."""

_MOST_GENERATED = 10**7
_NO_IDS = np.empty(0, dtype=np.int64)
System = tuple[FloatArray, FloatArray]
"""Axes as columns, and origin, of the rectangular system in which nodes are given."""


@dataclass(eq=False)
class NodesFound:
    """Scope, id, position and line of each node in the order of the file, and node sets.

    named : (scope, name, ids) of each set
    """

    scopes: IntArray
    ids: IntArray
    positions: FloatArray
    lines: IntArray
    named: list[tuple[int, str, IntArray]]


class _SetsAbove:
    """Sets above a keyword that generates nodes; these have no numbers at this stage."""

    def __init__(self) -> None:
        self._parts: dict[tuple[int, str], list[KeywordBlock | IntArray]] = {}
        self._unsorted: set[tuple[int, str]] = set()

    def add(self, scope: int, name: str, members: KeywordBlock | IntArray) -> None:
        """Add the ids of a *NSET keyword, or those of a keyword of nodes, which sorts the set."""
        key = scope, name.upper()
        if not isinstance(members, KeywordBlock):
            self._unsorted.discard(key)
        elif "UNSORTED" in members.options and key not in self._parts:
            self._unsorted.add(key)
        self._parts.setdefault(key, []).append(members)

    def ids(self, scope: int, name: str) -> IntArray:
        """Ids of a set, each once: in ascending order, or in that of the file if it is unsorted."""
        key = scope, name.upper()
        parts = self._parts.get(key, ())
        given = [plain_ids(each) if isinstance(each, KeywordBlock) else each for each in parts]
        found = np.concatenate([_NO_IDS, *given])
        return each_once(found) if key in self._unsorted else np.unique(found)


def read_nodes(file: KeywordFile, scopes: tuple[Scope, ...], blocks: tuple[ScopedBlock, ...]) -> NodesFound:
    """All nodes of a file, in its global axes.

    Raises
    ------
    ImportFormatError   words instead of numbers; *NMAP; generation with a bias or from unknown nodes
    """
    parts: list[tuple[int, IntArray, FloatArray, IntArray]] = [(0, _NO_IDS, np.empty((0, 3)), _NO_IDS)]
    sets = _SetsAbove()
    named: list[tuple[int, str, IntArray]] = []
    systems: dict[int, System] = {}
    for placed in blocks:
        block, scope = placed.block, placed.scope
        if block.key == "NMAP":
            raise file.error(block.line, f"*{block.name} is not supported; write the data explicitly")
        if block.key == "SYSTEM":
            systems[scope] = _system(file, block)
        elif block.key == "NSET" and not placed.step:
            sets.add(scope, block.options.get("NSET", ""), block)
        elif block.key in NODE_KEYWORDS and (block.data or block.key == "NCOPY") and not placed.step:
            system = systems.get(scope, (np.eye(3), np.zeros(3)))
            above = [part for part in parts if part[0] == scope and block.key != "NODE"] or parts[:1]
            known = np.concatenate([part[1] for part in above]), np.concatenate([part[2] for part in above])
            set_of = partial(sets.ids, scope)
            match block.key:
                case "NODE":
                    ids, positions, lines = _written(file, block, system)
                    bounds = ids[:0]
                case "NCOPY":
                    ids, positions, lines, bounds = _copied(file, block, known, set_of)
                case _:
                    ids, positions, lines, bounds = _generated(file, block, known, set_of, system)
            parts.append((scope, ids, positions, lines))
            if "NSET" in block.options or "NEWSET" in block.options:
                name = block.options.get("NSET", block.options.get("NEWSET", ""))
                members = ids if block.key == "NODE" else np.union1d(bounds, ids)
                named.append((scope, name, members))
                sets.add(scope, name, members)
    place = np.concatenate([np.full(len(ids), scope) for scope, ids, _, _ in parts])
    ids, positions, lines = (np.concatenate([part[i] for part in parts]) for i in (1, 2, 3))
    for number, scope in enumerate(scopes):
        mine = place == number
        if scope.name:
            positions[mine] = positions[mine] @ scope.rotation.T + scope.shift
    return NodesFound(place, ids, positions, lines, named)


def most_generated(file: KeywordFile, line: int, count: int) -> int:
    """The count; ImportFormatError if one line generates more than 10^7 nodes or elements."""
    if count > _MOST_GENERATED:
        raise file.error(
            line, f"{count} nodes or elements generated by one line; above the limit of a model: correct it"
        )
    return count


def _written(file: KeywordFile, block: KeywordBlock, system: System) -> tuple[IntArray, FloatArray, IntArray]:
    if "INPUT" in block.options:
        raise file.error(block.line, f"*{block.name}, INPUT= is not supported; write the data explicitly")
    ids, positions, lines = numbered_points(file, block)
    return ids, _in_global_axes(block, positions, system), lines


def _in_global_axes(block: KeywordBlock, x: FloatArray, system: System) -> FloatArray:
    """Positions (n, 3) given in the coordinates SYSTEM of a keyword."""
    match block.options.get("SYSTEM", "R").upper()[:1]:
        case "C":
            angle = np.radians(x[:, 1])
            x = np.column_stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]])
        case "S":
            theta, phi = np.radians(x[:, 1]), np.radians(x[:, 2])
            flat = x[:, 0] * np.cos(phi)
            x = np.column_stack([flat * np.cos(theta), flat * np.sin(theta), x[:, 0] * np.sin(phi)])
    rotation, origin = system
    return x @ rotation.T + origin


def _system(file: KeywordFile, block: KeywordBlock) -> System:
    """Axes as columns, and origin, of *SYSTEM: points at the origin, on axis 1, in the plane of axes 1, 2.

    The origin alone is a translation. With two points, axis 3 is the global z axis, and the direction to the
    second point is projected on the global xy plane.
    """
    rows = [numbers(file, line, fields(text)) for line, text in block.data[:2]]
    if sum(map(len, rows)) <= 3:
        return np.eye(3), np.array([*(rows[0] if rows else []), 0.0, 0.0, 0.0][:3])
    points = np.array([[*row, *6 * [0.0]][:6] for row in [*rows, []][:2]]).reshape(4, 3)[:3]
    origin, first = points[0], points[1] - points[0]
    second = points[2] - origin
    if len(rows) < 2:
        first = first * [1.0, 1.0, 0.0]
        second = np.cross([0.0, 0.0, 1.0], first)
    third = np.cross(first, second)
    if not np.linalg.norm(third) > 0:
        raise file.error(block.line, "*SYSTEM: its points give no axes; correct them")
    axes = [first, np.cross(third, first), third]
    return np.column_stack([axis / np.linalg.norm(axis) for axis in axes]), origin


def _generated(
    file: KeywordFile,
    block: KeywordBlock,
    known: tuple[IntArray, FloatArray],
    set_of: Callable[[str], IntArray],
    system: System,
) -> tuple[IntArray, FloatArray, IntArray, IntArray]:
    """Nodes on a line, arc or parabola between two nodes (*NGEN), or on lines between two sets (*NFILL).

    Returns ids, positions and lines, and the ids of the end nodes.
    """
    curve = block.options.get("LINE", "").upper()
    if curve not in ("", "C", "P") or "BIAS" in block.options or "SINGULAR" in block.options:
        raise file.error(
            block.line,
            f"*{block.name} of that kind or with a bias is not supported; write the data explicitly",
        )
    ids, positions = known

    def places(line: int, wanted: IntArray) -> FloatArray:
        found, there = positions_of_ids(ids, wanted)
        if not there.all():
            raise file.error(
                line, f"*{block.name} starts from node {wanted[~there][0]}, which is not above it"
            )
        return positions[found]

    made: list[tuple[IntArray, FloatArray, IntArray, IntArray]] = []
    for line, text in block.data:
        words = fields(text)
        plain = [int(word) if is_plain_digits(word) else -1 for word in words]
        if block.key == "NGEN":
            first, last, step = [*plain, 1][:3] if len(plain) > 1 else (-1, -1, 1)
            if min(first, last) < 0 or step < 1 or (last - first) % step:
                raise file.error(line, f"*NGEN takes first, last, step; got '{text[:40]}'")
            count = most_generated(file, line, abs(last - first) // step)
            starts, ends = np.array([first]), np.array([last])
            step = step if last > first else -step
        else:
            count, step = ([*plain, 1, 1][2:4]) if len(plain) > 2 else (-1, 1)
            starts, ends = (set_of(word) for word in [*words, ""][:2])
            if count < 1 or step < 1 or not len(starts) or len(starts) != len(ends):
                raise file.error(
                    line,
                    f"*NFILL takes two sets of equally many nodes, intervals, step; got '{text[:40]}'",
                )
            most_generated(file, line, count * len(starts))
        between = np.arange(1, count)
        x, y = places(line, starts), places(line, ends)
        share = (between / count)[:, None, None]
        new = (starts + step * between[:, None]).ravel()
        filled = ((1 - share) * x + share * y).reshape(-1, 3)
        if curve:
            given = numbers(file, line, [*words, *7 * [""]][3:10])
            if given[0]:
                extra = places(line, np.array([int(given[0])]))[0]
            else:
                extra = _in_global_axes(block, np.array([given[1:4]]), system)[0]
            if curve == "C":
                filled = _arc(x[0], y[0], extra, system[0] @ given[4:7], share[:, 0])
            else:
                filled = _parabola(x[0], y[0], extra, share[:, 0])
            if not np.isfinite(filled).all():
                raise file.error(
                    line,
                    "an arc of *NGEN, LINE=C must be less than half a circle, or have the normal of its "
                    "plane; take two arcs",
                )
        made.append((new, filled, np.full(len(new), line), np.concatenate([starts, ends])))
    new, filled, lines, bounds = (np.concatenate(each) for each in zip(*made, strict=True))
    return new, filled, lines, bounds


def _parabola(start: FloatArray, end: FloatArray, middle: FloatArray, t: FloatArray) -> FloatArray:
    """Positions (n, 3) at parameters t (n, 1) of the parabola through its middle."""
    return (1 - t) * (1 - 2 * t) * start + 4 * t * (1 - t) * middle + t * (2 * t - 1) * end


def _arc(
    start: FloatArray, end: FloatArray, centre: FloatArray, normal: FloatArray, t: FloatArray
) -> FloatArray:
    """Positions (n, 3) at fractions t (n, 1) of the angle of an arc, nan if it has no plane.

    normal : the arc turns right-handed about it; of length zero: the arc is less than half a circle
    """
    a, b = start - centre, end - centre
    across, least = np.cross(a, b), 1e-6 * np.linalg.norm(a) * np.linalg.norm(b)
    length = np.linalg.norm(normal)
    if not length:
        normal, length = across, np.linalg.norm(across)
        if not length > least:
            return np.full((len(t), 3), np.nan)
    normal = normal / length
    if not max(abs(a @ normal), abs(b @ normal)) <= 1e-3 * np.linalg.norm(a):
        return np.full((len(t), 3), np.nan)
    angle = np.arctan2(across @ normal, a @ b) % (2 * np.pi)
    radius = (1 - t) * np.linalg.norm(a) + t * np.linalg.norm(b)
    turned = np.cos(t * angle) * a + np.sin(t * angle) * np.cross(normal, a)
    return centre + radius / np.linalg.norm(a) * turned


def _copied(
    file: KeywordFile,
    block: KeywordBlock,
    known: tuple[IntArray, FloatArray],
    set_of: Callable[[str], IntArray],
) -> tuple[IntArray, FloatArray, IntArray, IntArray]:
    """Nodes of *NCOPY: those of a set, shifted and rotated (MULTIPLE times), or reflected.

    With a POLE p (a node or a position), x becomes 2 x - p. Returns ids, positions, lines and an empty
    array.
    """
    options, line = block.options, block.line
    old = set_of(options.get("OLDSET", ""))
    ids, positions = known
    place, there = positions_of_ids(ids, old)
    change = options.get("CHANGENUMBER", "")
    if not len(old) or not there.all() or not is_plain_digits(change):
        raise file.error(line, "*NCOPY takes CHANGE NUMBER and an OLD SET of nodes above it; correct them")
    values = np.array([[*numbers(file, at, fields(text)), *7 * [0.0]][:7] for at, text in block.placed_data])
    values = np.vstack([values.reshape(-1, 7), np.zeros((2, 7))])
    a, b, c = values[0, :3], values[0, 3:6], values[1, :3]
    if "SHIFT" in options:
        turn, shift, count = _rotation(values[1]), a, options.get("MULTIPLE", "1")
        pivot = values[1, :3]
    elif "POLE" in options:
        node = int(values[0, 0])
        at, there = positions_of_ids(ids, np.array([node]))
        if node and not there[0]:
            raise file.error(line, f"*NCOPY, POLE starts from node {node}, which is not above it")
        pole = positions[at[0]] if node else values[0, 1:4]
        made = old + int(change)
        return made, 2 * positions[place] - pole, np.full(len(made), line), old[:0]
    else:
        pivot, shift, count = a, np.zeros(3), "1"
        match options.get("REFLECT", "").upper():
            case "POINT":
                turn = -np.eye(3)
            case "LINE":
                turn = 2 * _projector(b - a) - np.eye(3)
            case "MIRROR":
                turn = np.eye(3) - 2 * _projector(np.cross(b - a, c - a))
            case _:
                raise file.error(line, "*NCOPY takes SHIFT, POLE or REFLECT=LINE, MIRROR, POINT; correct it")
    if not is_plain_digits(count) or not np.isfinite(turn).all():
        raise file.error(line, "*NCOPY: its points give no axis, or MULTIPLE is not a number; correct them")
    most_generated(file, line, int(count) * len(old))
    new, x = [], [positions[place]]
    for k in range(1, int(count) + 1):
        new.append(old + k * int(change))
        x.append((x[-1] + shift - pivot) @ turn.T + pivot)
    made = np.concatenate([old[:0], *new])
    return made, np.concatenate([positions[:0], *x[1:]]), np.full(len(made), line), old[:0]


def _rotation(values: FloatArray) -> FloatArray:
    """Rotation about the axis through two points, by an angle in degrees; the identity without an angle."""
    if not values[6]:
        return np.eye(3)
    axis = values[3:6] - values[:3]
    with np.errstate(invalid="ignore"):
        vector = np.radians(values[6]) * axis / np.linalg.norm(axis)
    return Rotation.from_rotvec(vector).as_matrix() if np.isfinite(vector).all() else np.full((3, 3), np.nan)


def _projector(direction: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore"):
        return np.outer(direction, direction) / (direction @ direction)


def plain_ids(block: KeywordBlock) -> IntArray:
    """Ids that a set keyword lists or generates, each once and in its order.

    Names of sets are omitted; a range is cut after 10^7 ids.
    """
    found: list[IntArray] = []
    for _, text in block.data:
        ids = [int(word) for word in fields(text) if is_plain_digits(word)]
        if "GENERATE" in block.options and len(ids) > 1:
            first, last, step = [*ids, 1][:3]
            count = min((last - first) // max(step, 1) + 1, _MOST_GENERATED)
            found.append(first + step * np.arange(max(count, 0), dtype=np.int64))
        else:
            found.append(np.array(ids, dtype=np.int64))
    return each_once(np.concatenate([_NO_IDS, *found]))


def each_once(numbers: IntArray) -> IntArray:
    """The numbers without repetition, in the order of their first places."""
    return numbers[np.sort(np.unique(numbers, return_index=True)[1])]
