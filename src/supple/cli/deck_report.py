"""Report of a deck for the terminal and as JSON, complete even if parts of the model fail."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from supple.body import MassProperties, deck_frequencies, deck_mass, deck_parts, missing_density
from supple.errors import SuppleError
from supple.importers.deck import BeamProperty, Deck, Property, ScalarTerms
from supple.results import without_noise
from supple.results.descriptions import Row


@dataclass(frozen=True)
class DeckReport:
    """Contents of a deck.

    mass : None if elements could not be created
    frequencies : cycles per unit of time of the deck; None if not requested, or not found
    faults : causes of missing values
    superelements : mass of each superelement by name; None if its elements could not be created
    """

    deck: Deck
    mass: MassProperties | None
    frequencies: tuple[float, ...] | None
    faults: tuple[str, ...]
    superelements: Mapping[str, MassProperties | None] = field(default_factory=dict)

    def as_json(self) -> dict[str, object]:
        """The documented output of `supple info --json`.

        The key `frequencies_hz` contains cycles per unit of time of the deck: Hz only for decks in seconds.
        """
        found: dict[str, object] = {
            **_described(self.deck, self.mass),
            "left_out": [
                {"card": each.card, "count": each.count, "line": each.line} for each in self.deck.left_out
            ],
        }
        if self.superelements:
            found["superelements"] = {
                name: _described(self.deck.superelements[name], mass)
                for name, mass in self.superelements.items()
            }
        if self.frequencies is not None:
            found["frequencies_hz"] = list(self.frequencies)
        return found


def _described(deck: Deck, mass: MassProperties | None) -> dict[str, object]:
    return {
        "nodes": len(deck.node_ids),
        "elements": element_counts(deck),
        "mass": None if mass is None else mass.mass,
        "centre": None if mass is None else mass.centre.tolist(),
        "inertia": None if mass is None else inertia_numbers(mass),
    }


def deck_report(deck: Deck, *, n_modes: int = 0, held: bool = False) -> DeckReport:
    """Report of a deck, with its mass, and with frequencies if requested.

    An error of the model does not end the report: the report contains its message in `faults`.

    n_modes : number of frequencies; 0: none
    held : frequencies of the model on the supports of the deck, instead of those of the free model
    """
    faults: list[str] = []
    mass = frequencies = None
    try:
        mass = deck_mass(deck)
    except SuppleError as error:
        faults.append(f"no mass: {error}")
    if mass is not None and not mass.mass > 0:
        faults.append("no density, and no concentrated masses: statics only; give the materials a density")
    elif mass is not None:
        if bare := missing_density(deck):
            faults.append(bare)
        if n_modes:
            try:
                frequencies = tuple(deck_frequencies(deck, n_modes, held=held).tolist())
            except SuppleError as error:
                faults.append(f"no frequencies: {error}")
    parts = {name: _mass(part) for name, part in deck.superelements.items()}
    return DeckReport(deck, mass, frequencies, tuple(faults), parts)


def _mass(deck: Deck) -> MassProperties | None:
    try:
        return deck_mass(deck)
    except SuppleError:
        return None


def element_counts(deck: Deck) -> dict[str, int]:
    """Number of elements of each type, by the name of the type in the file."""
    ids: dict[str, list[np.ndarray]] = {}
    for each in deck.elements:
        ids.setdefault(each.name, []).append(each.ids)
    return {name: len(np.unique(np.concatenate(own))) for name, own in ids.items()}


def inertia_numbers(mass: MassProperties) -> list[float]:
    """Ixx, Iyy, Izz, and the integrals xy, xz, yz about the centre."""
    J = mass.inertia
    return [float(value) for value in (J[0, 0], J[1, 1], J[2, 2], -J[0, 1], -J[0, 2], -J[1, 2])]


def deck_rows(report: DeckReport) -> Iterator[Row]:
    """All rows of a report, for the terminal."""
    deck, mass = report.deck, report.mass
    yield "what", f"{len(deck.node_ids)} nodes"
    if len(deck.nodes):
        for axis, low, high in zip("xyz", deck.nodes.min(axis=0), deck.nodes.max(axis=0), strict=True):
            yield axis, f"{low:g} to {high:g}"
    for name, count in element_counts(deck).items():
        yield f"elements {name}", str(count)
    for name, given in deck.properties.items():
        yield f"property {name}", _kind(given)
    if mass is not None:
        yield "mass", f"{mass.mass:.6g}"
        yield "centre", _listed(without_noise(mass.centre, like=deck.nodes))
        yield "inertia about the centre, xx yy zz xy xz yz", _listed(without_noise(inertia_numbers(mass)))
    yield from _parts(deck)
    yield from _beside(deck)
    yield from _named(deck)
    for name, own in report.superelements.items():
        weight = "" if own is None else f", mass {own.mass:.6g}"
        yield f"superelement {name}", f"{len(deck.superelements[name].node_ids)} nodes{weight}"
    if report.frequencies is not None:
        yield "frequencies", _listed(report.frequencies) + " cycles per unit of time"
    yield "cards read", _counted(deck.read)
    yield "cards ignored, without effect on a body", _counted(deck.passed_over)
    for each in deck.left_out:
        yield f"LEFT OUT {each.card}", f"{each.count}, first on line {each.line}: {each.meaning}"
    for note in (*deck.notes, *report.faults):
        yield "note", note


def _kind(given: Property) -> str:
    """Description of a property; for beams with the number of stress recovery points."""
    kind = type(given).__name__.removesuffix("Property").lower()
    if not isinstance(given, BeamProperty):
        return kind
    points = given.first.geometry.points if given.first.geometry else ()
    return (
        f"{kind}, stress at {len(points)} points" if points else f"{kind}, without points of stress recovery"
    )


def _named(deck: Deck) -> Iterator[Row]:
    """Named parts of a deck for use in a case."""
    for name, nodes in deck.node_sets.items():
        yield f"node set {name}", f"{len(nodes)} nodes"
    for name, members in deck.element_sets.items():
        yield f"element set {name}", f"{len(members)} elements"
    for tie in (*deck.rigid, *deck.means):
        yield f"connection {tie.name}", f"{len(tie.nodes)} nodes"


def _parts(deck: Deck) -> Iterator[Row]:
    parts = deck_parts(deck)
    if len(deck.scalar_points):
        yield "scalar points", f"{len(deck.scalar_points)}, which a free body cannot have"
    used = sum(len(part.node_ids) for part in parts.values())
    if used < len(deck.node_ids):
        yield "unused nodes", f"{len(deck.node_ids) - used}, dropped"
    if len(parts) < 2:
        return
    for name, part in list(parts.items())[:20]:
        elements = ", ".join(f"{count} {kind}" for kind, count in element_counts(part).items())
        yield f"part {name}", f"{len(part.node_ids)} nodes; {elements or 'no elements'}"
    if len(parts) > 20:
        yield "further parts", str(len(parts) - 20)


def _beside(deck: Deck) -> Iterator[Row]:
    """Springs, masses and constraints with their numbers."""
    counts = {
        "springs": sum(len(each.lines) for each in deck.springs),
        "dashpots": sum(len(each.lines) for each in deck.dashpots) + len(deck.dampings),
        "concentrated masses": len(deck.masses) + sum(_masses(each) for each in deck.inertias),
        "stiffness matrices": len(deck.stiffnesses),
        "constraints": sum(len(each.lines) for each in deck.constraints),
        "supports": sum(len(each.lines) for each in deck.held),
    }
    yield from ((what, str(count)) for what, count in counts.items() if count)


def _masses(terms: ScalarTerms) -> int:
    """Number of masses; a mass in x, y and z has a term of each, on one line and node."""
    rows, first = np.unique(terms.rows, return_index=True)
    return len(np.unique(np.column_stack([terms.lines[rows], terms.freedoms[first] // 6]), axis=0))


def _counted(cards: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {card}" for card, count in cards.items()) or "none"


def _listed(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.6g}" for value in values)
