"""Decks of Abaqus and CalculiX: the body described by an input file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import BoolArray
from supple.importers.abaqus.constraints import read_constraints
from supple.importers.abaqus.deck_model import AbaqusModel, read_model
from supple.importers.abaqus.element_types import CELL_FAMILIES, Family
from supple.importers.abaqus.freedoms import Freedoms, read_supports
from supple.importers.abaqus.keywords import LEFT_OUT, LEFT_OUT_OPTIONS, PASSED_OVER
from supple.importers.abaqus.lumped import read_masses, read_springs
from supple.importers.abaqus.orientation import read_orientations
from supple.importers.abaqus.public_names import public_ids, public_name, public_sets
from supple.importers.abaqus.report import Report
from supple.importers.abaqus.sections import read_elements
from supple.importers.abaqus.ties import read_ties
from supple.importers.deck import Deck
from supple.importers.keyword_file import KeywordBlock, read_keyword_file
from supple.importers.restricted_deck import restricted_deck


@checked_arguments
def read_abaqus_deck(path: str | Path) -> Deck:
    """The finite-element model of an Abaqus or CalculiX input file.

    Reads nodes, elements, sets, surfaces, instances, materials, sections, masses, springs, dashpots,
    constraints and supports. Steps are ignored, except the supports of the first step. Keywords without
    effect on an elastic body are counted in `passed_over`. Keywords that would change the body but are not
    read are listed in `left_out`.

    Raises
    ------
    ImportFormatError   a file that is missing, cut short or not an input file; words instead of numbers
    """
    file = read_keyword_file(Path(path))
    model = read_model(file)
    report, (node_ids, element_ids) = model.report, public_ids(model)
    orientations = read_orientations(model)
    freedoms = Freedoms(model)
    constraints = read_constraints(model, freedoms, node_ids, orientations)
    read_ties(model, constraints.rows)
    elements, properties = read_elements(model, element_ids, orientations)
    inertias, masses = read_masses(model, orientations)
    springs = read_springs(model, freedoms, Family.SPRING, "SPRING")
    dashpots = read_springs(model, freedoms, Family.DASHPOT, "DASHPOT")
    held = read_supports(model, freedoms)
    _account_for_the_rest(model)
    node_sets = public_sets(model, model.node_sets)
    for (scope, _), surface in model.surfaces.items():
        name = public_name(model, scope, surface.name, model.surfaces)
        if len(surface.nodes) and not np.array_equal(node_sets.get(name, []), surface.nodes):
            node_sets[f"surface {name}" if name in node_sets else name] = surface.nodes
    deck = Deck(
        Path(path),
        node_ids,
        model.positions,
        elements,
        properties,
        node_sets,
        {name: element_ids[of] for name, of in public_sets(model, model.element_sets).items()},
        masses=masses,
        springs=springs,
        dashpots=dashpots,
        inertias=inertias,
        constraints=constraints.rows.terms(constraints=True),
        held=held,
        rigid=tuple(constraints.rigid),
        means=tuple(constraints.means),
        read=dict(report.read),
        passed_over=dict(report.passed_over),
        left_out=report.left_out,
        notes=report.notes,
    )
    return decks_of_instances(deck, model)


def _account_for_the_rest(model: AbaqusModel) -> None:
    """Count the keywords that were not read: ignored ones as passed over, all others as left out."""
    report = model.report
    for placed in model.blocks:
        block = placed.block
        if placed.step:
            report.passed_over[block.name] += 1
        elif block.name in report.read:
            _leave_out_options(report, block)
        elif block.key in LEFT_OUT:
            report.leave_out_block(block, LEFT_OUT[block.key])
        elif block.key in PASSED_OVER:
            report.passed_over[block.name] += 1
        else:
            report.leave_out_block(block, "this keyword is not supported")
    stiff = any(block.type.family in CELL_FAMILIES for block in model.elements)
    for block in model.elements:
        if block.type.family is Family.PLANE:
            if stiff:
                report.passed_over[f"*ELEMENT, TYPE={block.type.name}"] += len(block.ids)
            else:
                report.leave_out_elements(block, np.arange(len(block.ids)), "a body is solid, not plane")


def _leave_out_options(report: Report, block: KeywordBlock) -> None:
    """Record options of a keyword that was read which would change the body."""
    if "INPUT" in block.options:
        meaning = "its data lines are in another file, which is not read; write them into this one"
        report.leave_out_block(block, meaning)
    for option in block.options:
        if (block.key, option) in LEFT_OUT_OPTIONS:
            meaning = LEFT_OUT_OPTIONS[block.key, option]
            report.leave_out(f"*{block.name}, {option}", block.line, meaning)


# --- instances of an assembly as separate decks, for machines with a body for each


def decks_of_instances(deck: Deck, model: AbaqusModel) -> Deck:
    """The deck; if it has several instances, `superelements` contains a deck for each of them."""
    names = [scope.name for scope in model.scopes[1:]]
    if len(names) < 2:
        return deck
    parts = {
        name: _part(deck, name, model.nodes.scopes == number)
        for number, name in enumerate(names, start=1)
        if (model.nodes.scopes == number).any()
    }
    return replace(deck, superelements=parts)


def _part(deck: Deck, name: str, mine: BoolArray) -> Deck:
    """The deck of one instance, on its nodes and reference nodes, with set names without INSTANCE.

    Constraints, springs and ties to other instances are omitted; joints between bodies replace them.
    """
    own = mine.copy()
    ties = (*deck.rigid, *deck.means)
    for tie in ties:
        own[tie.reference] |= mine[tie.nodes].all()
    made = restricted_deck(deck, own)
    ids = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *(each.ids for each in made.elements)]))
    element_sets = {key: of[np.isin(of, ids)] for key, of in deck.element_sets.items()}
    used = {each.property for each in made.elements}
    before = f"{name}."
    crossing = sum(bool(own[tie.nodes].any()) and not own[tie.nodes].all() for tie in ties)
    for terms in (*deck.springs, *deck.dashpots, *deck.constraints):
        inside, rows = own[terms.freedoms // 6], len(terms.lines)
        count = np.bincount(terms.rows[inside], minlength=rows)
        crossing += int(np.count_nonzero((count > 0) & (count < np.bincount(terms.rows, minlength=rows))))
    note = (
        f"{crossing} constraints or springs join instance '{name}' to others; between bodies, use joints "
        "instead"
    )
    return replace(
        made,
        properties={key: given for key, given in deck.properties.items() if key in used},
        node_sets={key.removeprefix(before): of for key, of in made.node_sets.items()},
        element_sets={key.removeprefix(before): of for key, of in element_sets.items() if len(of)},
        notes=(*deck.notes, note) if crossing else deck.notes,
    )
