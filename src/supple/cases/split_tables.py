"""The tables of a case, with split bodies replaced by their parts, tied by fixed joints."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from typing import Any

import numpy as np

from supple.arrays import IntArray
from supple.body import FlexibleBody, connection_named
from supple.cases.bodies import Body, NodalFixed
from supple.cases.case_tables import CaseTables
from supple.cases.damping import LinearRayleigh, Rayleigh, RayleighRatio
from supple.cases.interfaces import InterfaceTable
from supple.cases.joints import JointTable
from supple.cases.loads import Force
from supple.cases.split import SplitSource, pressed_triangles
from supple.cases.table import Made, named_in
from supple.errors import ModelError, SuppleWarning
from supple.machine import At
from supple.machine.split_body import SplitBody, frequency_changes, part_name


@dataclass(frozen=True, eq=False)
class _SplitTable:
    """The table of a split body, its source, and the number of the part with each interface, by name."""

    body: Body
    source: SplitSource
    holders: Mapping[str, int]

    def place(self, text: str) -> str:
        """`blade.root` becomes `blade-1.root`; node sets and other bodies are unchanged."""
        name, _, interface = text.partition(".")
        if name != self.body.name or interface not in self.holders:
            return text
        return f"{part_name(name, self.holders[interface])}.{interface}"


def with_parts(tables: CaseTables, split: Mapping[str, SplitSource]) -> CaseTables:
    """The case with split bodies replaced by their parts.

    Interfaces, frames, joints, loads and springs of a split body go to the part that contains them. Loads on
    nodes are distributed over the parts. Each cut gets a fixed joint.

    Parameters
    ----------
    split : the sources of each split body, by its name

    Raises
    ------
    ModelError   an interface whose nodes lie in several parts
    """
    if not split:
        return tables
    given = [_split_table(body, split[body.name]) for body in tables.body if body.name in split]
    by_name = {each.body.name: each for each in given}

    def placed(text: str) -> str:
        for each in given:
            text = each.place(text)
        return text

    def at_part(place: str, called: str) -> str:
        places = _places(placed(place), by_name)
        if len(places) > 1:
            raise ModelError(
                f"{called}: the nodes of '{place}' lie in {len(places)} of the parts; name an interface, or "
                "a set within one part"
            )
        return places[0][0]

    bodies = [
        part
        for body in tables.body
        for part in (_parts(by_name[body.name]) if body.name in by_name else [body])
    ]
    joints = [each.model_copy(update={"name": each.label}) for each in tables.joint]
    track = [place for text in tables.output.track for place, _ in _places(placed(text), by_name)]
    changed = {
        "body": tuple(bodies),
        "joint": (*joints, *(joint for each in given for joint in _ties(each))),
        "load": tuple(part for load in tables.load for part in _load_parts(load, placed, by_name)),
        "output": tables.output.model_copy(update={"track": tuple(track)}),
    }
    return _renamed(tables.model_copy(update=changed), at_part)


def _renamed(tables: CaseTables, at_part: Callable[[str, str], str]) -> CaseTables:
    """The case with every place named as a place of the part that contains it."""
    raw: Any = tables.model_dump(mode="json", exclude_unset=True)
    for (*outer, key), place, word in list(named_in(CaseTables, raw)):
        if word != "file":
            holder = reduce(getitem, outer, raw)
            name = holder.get("name") if isinstance(holder, dict) else None
            holder[key] = at_part(place, f"{outer[0]} '{name}'" if name else str(outer[0]))
    return CaseTables.model_validate(raw)


def base_of(body: Body, source: SplitSource) -> At | None:
    """The first interface of a split body, on its part; None for a body without interfaces.

    Raises
    ------
    ModelError   an interface whose nodes lie in several parts
    """
    for name, part in _split_table(body, source).holders.items():
        return At(part_name(body.name, part), name)
    return None


def with_damping(body: Body, whole: FlexibleBody) -> Body:
    """A split body with the same alpha and beta in all parts.

    A ratio refers to modes of the whole body. Modal damping is unchanged.

    Warns SuppleWarning if mass damping acts relative to the frame of each part instead of the body's.
    """
    damping = body.damping
    if isinstance(damping, RayleighRatio):
        assert body.frame is not None  # a rule of the case file
        made = damping.build(whole, body.frame.build())
        kind = damping.kind.removesuffix("-ratio")
        table = Rayleigh if kind == "rayleigh" else LinearRayleigh
        damping = table(kind=kind, alpha=made.alpha, beta=made.beta)
    elif isinstance(damping, Rayleigh | LinearRayleigh):
        damping = damping.model_copy(update={"held": None})  # an interface of one part alone
    if isinstance(damping, Rayleigh | LinearRayleigh) and damping.alpha > 0:
        warnings.warn(
            f"body '{body.name}' is split: its mass damping, alpha = {damping.alpha:.3g}, acts on motion "
            "relative to each part's frame, so that the lowest modes of the whole are damped less; "
            "choose beta alone for a damping that does not depend on the frames",
            SuppleWarning,
            stacklevel=2,
        )
    return body.model_copy(update={"damping": damping})


def changed_frequencies(whole: FlexibleBody, split: SplitBody) -> str:
    """One line on the changes of a split body's lowest free frequencies by its ties, in per cent.

    Warns SuppleWarning if one of them changes by 2 % or more.
    """
    changes = ", ".join(f"{100 * change:+.2g}" for change in frequency_changes(whole, split))
    return (
        f"split body '{whole.name}' into {len(split.parts)}; the ties change its lowest free frequencies by "
        f"{changes} %"
    )


def _split_table(body: Body, source: SplitSource) -> _SplitTable:
    holders = {}
    for interface in body.interface:
        part = source.mesh.holder(_nodes(interface, source))
        if part is None:
            raise ModelError(
                f"body '{body.name}', interface '{interface.name}': its nodes lie in several of the "
                f"{len(source.mesh.parts)} parts; move the cut away from it"
            )
        holders[interface.name] = part
    return _SplitTable(body, source, holders)


def _nodes(interface: InterfaceTable, source: SplitSource) -> IntArray:
    if interface.connection is not None:
        return connection_named(interface.connection, source.whole.connections()).nodes
    if interface.nodes is not None:
        return source.mesh.whole.nodes_of(interface.nodes)
    return source.whole.numbers(np.array(interface.node_indices))


def _parts(split: _SplitTable) -> Iterator[Body]:
    """A table for each part of a split body."""
    body, mesh = split.body, split.source.mesh
    assert body.split is not None
    for i in range(len(mesh.parts)):
        # The nodes of a part keep their ids.
        own = [each for each in body.interface if split.holders[each.name] == i]
        for cut, nodes in mesh.cut_nodes(i).items():
            tied = {
                "name": cut,
                "nodes": f"{cut} of {body.name}",
                "kind": "averaging" if body.split.tie == "averaging" else "rigid",
                "position": mesh.whole.nodes[nodes].mean(axis=0).tolist(),
            }
            own.append(InterfaceTable.model_validate(tied))
        changed = {
            "name": part_name(body.name, i),
            "interface": tuple(own),
            "frame": _frame(split, i),
            "split": None,
        }
        yield body.model_copy(update=changed)


def _frame(split: _SplitTable, part: int) -> Made | None:
    """The frame of a part.

    A mean-axis frame is that of the body. A nodal-fixed frame is fixed to the interface of the body's frame,
    or, in a part without this interface, to the cut towards it.
    """
    frame = split.body.frame
    if not isinstance(frame, NodalFixed):
        return frame
    held = split.holders[frame.interface]
    if part == held:
        return frame
    towards = dict(split.source.mesh.neighbours_from(held))
    return NodalFixed(kind="nodal-fixed", interface=towards[part].name)


def _ties(split: _SplitTable) -> Iterator[JointTable]:
    name = split.body.name
    for tie, cut in split.source.mesh.ties.items():
        first, second = (f"{part_name(name, part)}.{cut.name}" for part in (cut.first, cut.second))
        table = {"kind": "fixed", "name": f"{name} {tie}", "first": first, "second": second}
        yield JointTable.model_validate(table)


def _places(text: str, split: Mapping[str, _SplitTable]) -> Sequence[tuple[str, float]]:
    """The places in the parts that together form the given place, each with its fraction of the nodes."""
    name, _, node_set = text.partition(".")
    if name not in split:
        return [(text, 1.0)]
    nodes = split[name].source.mesh.whole.nodes_of(node_set)
    found = split[name].source.places(nodes)
    return [(f"{part}.{node_set}", len(own) / len(nodes)) for part, own in found]


def _load_parts(load: Made, placed: Callable[[str], str], split: Mapping[str, _SplitTable]) -> Iterator[Made]:
    name, _, node_set = getattr(load, "at", "").partition(".")
    if isinstance(load, Force):
        for place, share in _places(placed(load.at), split):
            vector = tuple(share * component for component in load.vector)
            yield load.model_copy(update={"at": place, "vector": vector})
    elif name in split:  # a pressure
        source = split[name].source
        loaded = [part for part in source.parts if len(pressed_triangles(source, part, node_set))]
        for part in loaded or list(source.parts)[:1]:  # without a face, `build` raises the error
            yield load.model_copy(update={"at": f"{part}.{node_set}"})
    else:
        yield load
