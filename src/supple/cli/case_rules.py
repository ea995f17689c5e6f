"""What the keys of a case file demand of each other: rules over the raw tables.

The rules read the raw data, not the validated schema, so that they all run even when other keys are wrong and
every mistake is reported at once. A value of the wrong type is the schema's business: rules pass it over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, get_args

from supple.cases.case_tables import JointKind
from supple.cases.line_index import KeyPath
from supple.cli.did_you_mean import did_you_mean
from supple.importers import MESH_SUFFIXES, NASTRAN_SUFFIXES, NODE_SUFFIXES

Raw = Mapping[str, Any]
Mistakes = Iterator[tuple[KeyPath, str]]

_BODY_KINDS = ("shell", "solid", "nastran", "matrices", "superelement", "rigid", "reduced")
_KINDS_WITH_MESH = ("shell", "solid", "nastran", "matrices")
_KINDS_WITH_STRESS = ("shell", "solid", "nastran")
_ELASTIC_ONLY = ("frame", "reduction", "damping", "linear")
_INTERFACE_BASES = (
    "rubin",
    "craig-bampton",
    "craig-bampton-residual",
    "herting",
    "guyan",
    "error-controlled",
)


def broken_rules(raw: Raw, folder: Path) -> list[tuple[KeyPath, str]]:
    """Every broken rule of a case: the path of the key to look at, and what is wrong with the remedy.

    Parameters
    ----------
    raw : mapping    the case as the TOML reader returns it
    folder : Path    where the case file lies: its file names are relative to it
    """
    rules: tuple[Callable[[Raw], Mistakes], ...] = (
        _has_bodies,
        _bodies_are_of_one_kind,
        _interfaces_suit_their_body,
        _names_are_unique,
        _frames_and_damping_name_an_interface,
        _joints_have_what_their_kind_needs,
        _axes_have_a_length,
        _ends_exist,
        _loads_suit_their_place,
        _nonlinear_options_have_strains,
        _bases_have_interfaces,
        _selections_have_candidates,
        _sizes_are_fixed_or_corrected,
        _time_steps_are_given_once,
        _damped_modes_differ,
        _stress_has_elements,
    )
    mistakes = [mistake for rule in rules for mistake in rule(raw)]
    return mistakes + list(_files_exist(raw, folder))


def _has_bodies(raw: Raw) -> Mistakes:
    if raw.get("body") == []:
        yield ("body",), "a case needs at least one [[body]]"


def _bodies_are_of_one_kind(raw: Raw) -> Mistakes:
    for path, body in _tables(raw, "body"):
        given = [kind for kind in _BODY_KINDS if kind in body]
        if len(given) != 1:
            seen = f"this one has {' and '.join(given)}" if given else "this one has none"
            yield path, f"a body needs exactly one of {', '.join(_BODY_KINDS)}; {seen}"
            continue
        kind = given[0]
        if kind in _KINDS_WITH_MESH and "mesh" not in body:
            yield path, f'a {kind} body needs a mesh; add mesh = "FILE{_mesh_suffixes(body)[0]}"'
        if kind not in _KINDS_WITH_MESH and "mesh" in body:
            yield (*path, "mesh"), f"a {kind} body takes no mesh; remove the key"
        if kind in ("rigid", "reduced"):
            for key in (key for key in _ELASTIC_ONLY if key in body):
                yield (*path, key), f"a {kind} body takes no {key}; remove the key"
        elif "frame" not in body:
            yield path, f'a {kind} body needs frame; for example frame = {{kind = "mean-axis"}}'


def _interfaces_suit_their_body(raw: Raw) -> Mistakes:
    for path, body in _tables(raw, "body"):
        if "reduced" in body:
            continue
        for place, interface in _tables(body, "interface", path):
            sources = [key for key in ("nodes", "node_indices", "connection") if key in interface]
            if "rigid" in body:
                if sources:
                    yield (
                        (*place, sources[0]),
                        f"a rigid body has no nodes; give position instead of {sources[0]}",
                    )
                elif "position" not in interface:
                    yield place, "an interface of a rigid body needs position = [x, y, z] in body axes"
            elif len(sources) != 1:
                yield (
                    place,
                    "an interface needs one of nodes (a node set's name), node_indices and connection (an "
                    f"RBE2 or RBE3); this one has {' and '.join(sources) or 'none'}",
                )
            elif sources == ["connection"]:
                if "nastran" not in body and "matrices" not in body:
                    yield (
                        (*place, "connection"),
                        "only nastran and matrices bodies have connections; give nodes",
                    )
                for key in (key for key in ("kind", "position") if key in interface):
                    yield (*place, key), f"a connection has its own {key}; remove the key"
            elif "superelement" in body and "nodes" in interface:
                yield (*place, "nodes"), "a superelement has no node sets; give node_indices (from 0) instead"


def _names_are_unique(raw: Raw) -> Mistakes:
    yield from _unusable_names(raw, "body", ())
    for path, body in _tables(raw, "body"):
        yield from _unusable_names(body, "interface", path)
    yield from _unusable_names(raw, "joint", ())


def _unusable_names(table: Raw, key: str, path: KeyPath) -> Mistakes:
    taken: set[str] = set()
    for place, item in _tables(table, key, path):
        name = item.get("name")
        if not isinstance(name, str):
            continue
        if name in taken:
            yield (*place, "name"), f"an earlier {key} is already named {name!r}; names must differ"
        if "." in name or name == "ground":
            yield (*place, "name"), f"{name!r} cannot be a {key} name: no dots, and not the word ground"
        taken.add(name)


def _frames_and_damping_name_an_interface(raw: Raw) -> Mistakes:
    for path, body in _tables(raw, "body"):
        for key, inner in (("frame", "interface"), ("damping", "held")):
            table = body.get(key)
            wanted = table.get(inner) if isinstance(table, Mapping) else None
            if isinstance(wanted, str) and wanted not in _interface_names(body):
                yield (*path, key, inner), _unknown("interface", wanted, _interface_names(body))


def _joints_have_what_their_kind_needs(raw: Raw) -> Mistakes:
    for path, joint in _tables(raw, "joint"):
        kind = joint.get("kind")
        if not isinstance(kind, str) or kind not in get_args(JointKind):
            continue
        needs = {
            "axis": kind not in ("fixed", "ball"),
            "second_axis": kind == "universal",
            "law": kind.startswith("prescribed"),
        }
        for key, needed in needs.items():
            if needed and key not in joint:
                yield path, f"a {kind} joint needs {key}; add {key} = {_EXAMPLES[key]}"
            if key in joint and not needed:
                yield (*path, key), f"a {kind} joint takes no {key}; remove the key"


_EXAMPLES = {
    "axis": "[1, 0, 0]",
    "second_axis": "[0, 1, 0]",
    "law": '{kind = "spin-up", speed = 1.0, duration = 10.0}',
}


def _axes_have_a_length(raw: Raw) -> Mistakes:
    for path, table in (*_tables(raw, "joint"), *_tables(raw, "spring")):
        for key in ("axis", "second_axis"):
            if table.get(key) == [0, 0, 0]:
                yield (*path, key), "an axis of length zero has no direction; give for example [1, 0, 0]"


def _loads_suit_their_place(raw: Raw) -> Mistakes:
    """A node set carries forces only: it has no axes for a load to turn with, nor rotations for a torque."""
    interfaces = {
        f"{body.get('name')}.{name}" for _, body in _tables(raw, "body") for name in _interface_names(body)
    }
    for path, load in _tables(raw, "load"):
        if (load.get("kind") == "torque" or load.get("follower") is True) and load.get(
            "at"
        ) not in interfaces:
            yield (
                (*path, "at"),
                "a torque or a follower load acts at an interface; add one around these nodes",
            )


def _ends_exist(raw: Raw) -> Mistakes:
    for key in ("joint", "spring"):
        for path, table in _tables(raw, key):
            ground = table.get("kind") != "straight"
            yield from _end_exists(raw, (*path, "first"), table.get("first"), ground=ground)
            yield from _end_exists(raw, (*path, "second"), table.get("second"), ground=False)
    for path, load in _tables(raw, "load"):
        yield from _end_exists(raw, (*path, "at"), load.get("at"), ground=False, node_sets=True)
    output = raw.get("output")
    tracked = output.get("track") if isinstance(output, Mapping) else None
    for position, place in enumerate(tracked if isinstance(tracked, list) else []):
        yield from _end_exists(raw, ("output", "track", position), place, ground=False, node_sets=True)


def _end_exists(raw: Raw, path: KeyPath, end: Any, *, ground: bool, node_sets: bool = False) -> Mistakes:
    """Check one BODY.PLACE; whether a node set exists is known only once the mesh has been read."""
    if not isinstance(end, str):
        return
    if end == "ground":
        if not ground:
            yield (
                path,
                "ground cannot stand here, only as first end of a joint or torsion spring",
            )
        return
    bodies = {str(body.get("name")): body for _, body in _tables(raw, "body")}
    name, dot, place = end.partition(".")
    if not dot:
        wanted = "ground or BODY.INTERFACE" if ground else "BODY.INTERFACE"
        nearest = did_you_mean(end, ["ground"] if ground else [])
        yield path, f"{end!r} is not {wanted}{nearest}; for example {next(iter(bodies), 'blade')}.root"
    elif name not in bodies:
        yield path, _unknown("body", name, list(bodies))
    elif place not in _interface_names(bodies[name]) and not (
        node_sets and "mesh" in bodies[name] and "matrices" not in bodies[name]
    ):
        yield path, _unknown(f"interface of {name!r}", place, _interface_names(bodies[name]))


def _time_steps_are_given_once(raw: Raw) -> Mistakes:
    simulation = raw.get("simulation")
    if not isinstance(simulation, Mapping):
        return
    if ("step" in simulation) == ("adaptive" in simulation):
        path: KeyPath = ("simulation", "step") if "step" in simulation else ("simulation",)
        yield path, "give either step = SECONDS or adaptive = {first = .., largest = ..}, not both or none"
    adaptive = simulation.get("adaptive")
    if isinstance(adaptive, Mapping):
        first, largest = adaptive.get("first"), adaptive.get("largest")
        if isinstance(first, int | float) and isinstance(largest, int | float) and first > largest:
            yield (
                ("simulation", "adaptive", "first"),
                f"the first step, {first} s, exceeds the largest, {largest} s",
            )
    output_step, duration = simulation.get("output_step"), simulation.get("duration")
    if not (isinstance(output_step, int | float) and isinstance(duration, int | float)) or output_step <= 0:
        return
    path = ("simulation", "output_step")
    intervals = duration / output_step
    if intervals < 1:
        yield path, f"{output_step} s is longer than the duration, {duration} s"
    elif abs(intervals - round(intervals)) > 1e-6:
        better = duration / round(intervals)
        yield path, f"the duration, {duration} s, is not a multiple of {output_step} s; try {better:.6g}"


def _nonlinear_options_have_strains(raw: Raw) -> Mistakes:
    """Modal derivatives come from quadratic strains; modal damping needs modes."""
    for path, body in _tables(raw, "body"):
        reduction = body.get("reduction")
        if not isinstance(reduction, Mapping):
            continue
        derivatives = reduction.get("derivatives")
        wanted = isinstance(derivatives, Mapping) and derivatives.get("kind") in ("compressed", "picked")
        if wanted and ("superelement" in body or "matrices" in body or body.get("linear") is True):
            yield (
                (*path, "reduction", "derivatives"),
                "a linear body has no modal derivatives; remove the key",
            )
        damping = body.get("damping")
        modal = isinstance(damping, Mapping) and damping.get("kind") == "modal"
        if modal and reduction.get("basis") == "none":
            yield (
                (*path, "damping", "kind"),
                "a body that is not reduced takes rayleigh or rayleigh-ratio damping",
            )


def _bases_have_interfaces(raw: Raw) -> Mistakes:
    for path, body in _tables(raw, "body"):
        reduction = body.get("reduction")
        basis = reduction.get("basis") if isinstance(reduction, Mapping) else None
        if basis in _INTERFACE_BASES and _is_made_here(body) and not _interface_names(body):
            yield (
                (*path, "reduction", "basis"),
                f'{basis} needs an interface; add [[body.interface]], or take basis = "normal-modes"',
            )


def _selections_have_candidates(raw: Raw) -> Mistakes:
    for path, body in _tables(raw, "body"):
        reduction = body.get("reduction")
        candidates = reduction.get("candidates") if isinstance(reduction, Mapping) else None
        if not (isinstance(candidates, int) and isinstance(reduction, Mapping)):
            continue
        place, modes = (*path, "reduction", "candidates"), reduction.get("modes")
        if reduction.get("select", "lowest-frequency") == "lowest-frequency":
            yield (
                place,
                'the lowest modes are kept unless told otherwise; remove the key, or add select = "coupling-'
                'moment" or "effective-interface-mass"',
            )
        if isinstance(modes, int) and modes > candidates:
            yield place, f"{modes} modes cannot be selected among {candidates} candidates; give more"


def _sizes_are_fixed_or_corrected(raw: Raw) -> Mistakes:
    """A reduction has a fixed size, or corrects itself: then with a damping that the full body can have."""
    for path, body in _tables(raw, "body"):
        reduction = body.get("reduction", {})
        if not (_is_made_here(body) and isinstance(reduction, Mapping)):
            continue
        if reduction.get("basis") in ("none", "error-controlled"):  # which have one size
            continue
        accuracy = reduction.get("accuracy")
        if isinstance(accuracy, Mapping) and "relative" in accuracy and "absolute" in accuracy:
            yield (
                (*path, "reduction", "accuracy", "absolute"),
                "give the error either as relative or as absolute (m), not both",
            )
        sized = "modes" in reduction or reduction.get("basis") == "guyan"
        if "derivatives" in reduction and not sized and accuracy is None:
            yield (
                (*path, "reduction", "derivatives"),
                "a basis of fixed size needs modes too; add modes = 10, or accuracy = {relative = 1e-3} "
                "to start with these derivatives and correct itself",
            )
        damping = body.get("damping")
        modal = isinstance(damping, Mapping) and damping.get("kind") == "modal"
        if modal and (accuracy is not None or not sized):
            yield (
                (*path, "damping", "kind"),
                "a reduction that corrects itself takes rayleigh or rayleigh-ratio damping; or fix its size "
                "with modes = 10 and derivatives = {..}",
            )


def _damped_modes_differ(raw: Raw) -> Mistakes:
    for path, body in _tables(raw, "body"):
        damping = body.get("damping")
        modes = damping.get("modes") if isinstance(damping, Mapping) else None
        if isinstance(modes, list) and len(modes) == 2 and (modes[0] == modes[1] or min(modes) < 1):
            yield (
                (*path, "damping", "modes"),
                f"give two different mode numbers from 1, for example [1, 2]; got {modes}",
            )


def _stress_has_elements(raw: Raw) -> Mistakes:
    output = raw.get("output")
    if not isinstance(output, Mapping) or output.get("colour") != "von-mises":
        return
    if not any(kind in body for _, body in _tables(raw, "body") for kind in _KINDS_WITH_STRESS):
        yield (
            ("output", "colour"),
            f"no body has elements whose stress could be shown ({', '.join(_KINDS_WITH_STRESS)}); remove the "
            "key",
        )


def _files_exist(raw: Raw, folder: Path) -> Mistakes:
    for path, name in _files(raw):
        if not (folder / name).is_file():
            yield path, f"there is no file {folder / name}; file names are relative to the case file"
    for path, body in _tables(raw, "body"):
        mesh = body.get("mesh")
        if isinstance(mesh, str) and Path(mesh).suffix.lower() not in _mesh_suffixes(body):
            allowed = " or ".join(_mesh_suffixes(body))
            yield (*path, "mesh"), f"{mesh!r} is not a mesh that can be read: {allowed}"


def _mesh_suffixes(body: Raw) -> tuple[str, ...]:
    """Suffixes of the mesh files that a body of this kind takes."""
    if "nastran" in body:
        return NASTRAN_SUFFIXES
    return NODE_SUFFIXES if "matrices" in body else MESH_SUFFIXES


def _files(raw: Raw) -> Iterator[tuple[KeyPath, str]]:
    for path, body in _tables(raw, "body"):
        yield from _strings(body, ("mesh",), path)
        if isinstance(body.get("matrices"), Mapping):
            yield from _strings(body["matrices"], ("stiffness", "mass"), (*path, "matrices"))
        if isinstance(body.get("superelement"), Mapping):
            yield from _strings(body["superelement"], ("stiffness", "mass", "nodes"), (*path, "superelement"))
    for key in ("joint", "load"):
        for path, table in _tables(raw, key):
            if isinstance(table.get("law"), Mapping):
                yield from _strings(table["law"], ("file",), (*path, "law"))


def _strings(table: Raw, keys: tuple[str, ...], path: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    return (((*path, key), table[key]) for key in keys if isinstance(table.get(key), str))


def _tables(raw: Raw, key: str, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Raw]]:
    """The items of an array of tables with their paths; nothing if `key` holds something else."""
    items = raw.get(key)
    for position, item in enumerate(items if isinstance(items, list) else []):
        if isinstance(item, Mapping):
            yield (*path, key, position), item


def _is_made_here(body: Raw) -> bool:
    """True of an elastic body that the case builds, and may reduce."""
    return "rigid" not in body and "reduced" not in body


def _interface_names(body: Raw) -> list[str]:
    return [str(interface.get("name")) for _, interface in _tables(body, "interface")]


def _unknown(what: str, name: str, known: list[str]) -> str:
    listed = ", ".join(dict.fromkeys(known)) or "none"
    return f"there is no {what} named {name!r}{did_you_mean(name, known)}; there is: {listed}"
