"""Summary of a case, mesh or result file."""

from __future__ import annotations

from collections.abc import Iterator
from json import dumps
from pathlib import Path

from supple.cases import read_case
from supple.cli.deck_report import deck_report, deck_rows
from supple.errors import ArgumentError, ImportFormatError
from supple.importers import (
    DECK_SUFFIXES,
    MESH_SUFFIXES,
    SECTION_SUFFIXES,
    is_section_file,
    read_deck,
    read_mesh,
    read_section_table,
)
from supple.importers.deck import Deck
from supple.importers.nastran.deck_file import has_no_sections
from supple.machine import MUJOCO_SUFFIXES
from supple.results.descriptions import describe_result
from supple.storage import holds_reduced_body, read_reduced_body
from supple.summary import Row
from supple.terminal import print_rows
from supple.units import with_unit


def print_info(path: Path, *, json: Path | None = None, n_modes: int = 0, held: bool = False) -> None:
    """Print a summary of the file at `path`: a case, mesh, deck, section table or result.

    json : output file for the numbers of a deck
    n_modes : number of lowest frequencies of a deck to compute
    held : compute these frequencies with the supports of the deck, instead of for the free model

    Raises
    ------
    ArgumentError    these options for a file that is not a deck; `held` without `n_modes`; `json` is `path`
    CaseError, ImportFormatError, MeshError, ResultFileError    a file that cannot be read, or of another kind
    """
    suffix = path.suffix.lower()
    of_sections = is_section_file(path)
    if suffix in DECK_SUFFIXES and not of_sections:
        if held and not n_modes:
            raise ArgumentError("--held is for frequencies: give their number as well, such as --modes 6")
        if json is not None and json.resolve() == path.resolve():
            raise ArgumentError(f"cannot write {json}: it is the deck itself and would be lost")
        deck = read_deck(path)
        if json is None and not n_modes and is_only_a_mesh(deck):
            print_rows(f"Mesh {path}", read_mesh(path).summary().rows)
            return
        report = deck_report(deck, n_modes=n_modes, held=held)
        print_rows(f"Deck {path}", deck_rows(report))
        if json is not None:
            json.parent.mkdir(parents=True, exist_ok=True)
            json.write_text(f"{dumps(report.as_json(), indent=1)}\n", encoding="utf-8")
        return
    if json is not None or n_modes or held:
        raise ArgumentError(
            f"{path}: --json, --modes and --held are for decks, which end in {', '.join(DECK_SUFFIXES)}"
        )
    if suffix == ".toml":
        print_rows(f"Case {path}", _describe_case(path))
    elif suffix == ".h5" and holds_reduced_body(path):
        print_rows(f"Reduced body {path}", read_reduced_body(path).summary().rows)
    elif suffix == ".h5":
        print_rows(f"Result {path}", describe_result(path))
    elif of_sections:
        print_rows(f"Section table {path}", _describe_sections(path))
    elif suffix in MESH_SUFFIXES:
        print_rows(f"Mesh {path}", read_mesh(path).summary().rows)
    else:
        known = ", ".join(dict.fromkeys((".toml", ".h5", *MESH_SUFFIXES, *SECTION_SUFFIXES)))
        machine = f"; write a case with this machine: supple new {path}" if suffix in MUJOCO_SUFFIXES else ""
        raise ImportFormatError(f"{path}: unknown kind of file; give one that ends in {known}{machine}")


def is_only_a_mesh(deck: Deck) -> bool:
    """Whether a deck has elements, but no sections, masses, springs or ties, as the mesh of a `shell`."""
    model = (deck.elements, deck.properties, deck.masses, deck.stiffnesses, deck.springs, deck.inertias)
    connected = (deck.constraints, deck.rigid, deck.means, deck.superelements)
    if any(map(len, (*model, *connected))) or not deck.left_out:
        return False
    if deck.path.suffix.lower() != ".inp" and not has_no_sections(deck.read):
        return False
    return all(
        each.meaning.startswith(("elements without a section", "elements left out: their property"))
        for each in deck.left_out
    )


def _describe_sections(path: Path) -> Iterator[Row]:
    table = read_section_table(path)
    yield "sections", str(table.n)
    yield "length along the curve", f"{table.lengths[-1]:.6g}"
    yield "mass", f"{table.mass:.6g}"
    for end, k in (("root", 0), ("tip", -1)):
        stiffness = table.stiffness[k].diagonal()[2:]
        yield f"{end}, position", ", ".join(f"{value:.6g}" for value in table.positions[k])
        yield f"{end}, mass per length", f"{table.inertia[k, 0, 0]:.6g}"
        yield f"{end}, EA, EI about x, EI about y, GJ", ", ".join(f"{value:.4g}" for value in stiffness)


def _describe_case(path: Path) -> Iterator[Row]:
    read = read_case(path)
    case, time = read.tables, read.units.time
    yield "units", str(read.units) or "not stated"
    yield "what", case.title
    for body in case.body:
        basis = f", basis {body.reduction.chosen}" if body.reduction else ""
        basis += ", corrects itself" if body.corrects_itself else ""
        basis += f", modal in {body.modal.modes} modes" if body.modal else ""
        basis += ", explicit elements" if body.explicit else ""
        interfaces = ", ".join(interface.name for interface in body.interface) or "none"
        yield f"body {body.name}", f"{body.kind}{basis}; interfaces: {interfaces}"
    for joint in case.joint:
        yield f"joint {joint.name or ''}", f"{joint.kind}: {joint.first} - {joint.second}"
    for load in case.load:
        place = getattr(load, "at", None)
        yield "load", load.chosen if place is None else f"{load.chosen} at {place}"
    for tie in case.tie:
        yield "tie", f"{tie.nodes} on {tie.on}"
    for contact in case.contact:
        yield "contact", f"{contact.nodes} with {getattr(contact.obstacle, 'kind', contact.surface)}"
    for support in case.support:
        yield "support", f"{support.nodes}, fixed in {support.axes}"
    for spring in (*case.spring, *case.element):
        what = "spring" if spring in case.spring else "element"
        yield f"{what} {spring.name or ''}".strip(), f"{spring.chosen}: {spring.first} - {spring.second}"
    if case.control is not None:
        yield "control", case.control
    for sensor in case.sensor:
        place = getattr(sensor, "at", None)
        yield f"sensor {sensor.name}", sensor.chosen if place is None else f"{sensor.chosen} at {place}"
    if case.spin is not None:
        spin, unit = case.spin, read.units.angular_velocity
        turned = ", ".join(spin.bodies or ()) or "all bodies"
        yield "spin", f"{with_unit(f'{spin.rate:g}', unit)} about {list(spin.axis)}: {turned}"
    run = case.simulation
    duration, stored = (with_unit(f"{each:g}", time) for each in (run.duration, run.output_step))
    yield "simulation", f"{duration}, stored every {stored}"
