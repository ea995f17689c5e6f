"""Supports of Abaqus and CalculiX: *BOUNDARY of the model and of its first step, without driven freedoms."""

from __future__ import annotations

from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.freedoms import Freedoms
from supple.importers.deck import ScalarTerms
from supple.importers.freedom_sums import FreedomSums
from supple.importers.keyword_file import fields, numbers
from supple.importers.plain_number import is_plain_digits

_NAMED = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6), "PINNED": (1, 2, 3), "XSYMM": (1, 5, 6), "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5), "XASYMM": (2, 3, 4), "YASYMM": (1, 3, 5), "ZASYMM": (1, 2, 6), "NOWARP": (),
    "NOOVAL": (), "NODEFORM": (),
}  # fmt: skip


def read_supports(model: AbaqusModel, freedoms: Freedoms) -> tuple[ScalarTerms, ...]:
    """The freedoms that are fixed, each once, as constraints.

    Raises
    ------
    ImportFormatError   words instead of numbers; an unknown type of support
    """
    rows = FreedomSums()
    held: set[tuple[int, int]] = set()
    for placed in model.blocks:
        block = placed.block
        # These options prescribe motions.
        driven = {"SUBMODEL", "USER", "TYPE"} & block.options.keys()
        if block.key != "BOUNDARY" or placed.step > 1 or (driven and placed.step):
            continue
        if placed.step == 0:
            model.report.read[block.name] += 1
        for line, text in block.data:
            words = fields(text)
            nodes = model.nodes_of(placed.scope, words[0], line, "*BOUNDARY")
            for component in _components(model, line, words):
                for node in nodes.tolist():
                    if (node, component) not in held:
                        held.add((node, component))
                        rows.add(freedoms.of(node, component), model.file.numbers[line])
    return rows.terms(constraints=True)


def _components(model: AbaqusModel, line: int, words: list[str]) -> list[int]:
    """Freedoms 1 to 6 that a line fixes; none if it gives a displacement other than 0."""
    if len(words) < 2 or not words[1]:
        return []
    if words[1].upper() in _NAMED:
        return list(_NAMED[words[1].upper()])
    if not is_plain_digits(words[1]) or (len(words) > 2 and words[2] and not is_plain_digits(words[2])):
        raise model.file.error(
            line, f"*BOUNDARY fixes freedoms 1 to 6, or {', '.join(_NAMED)}; '{words[1][:40]}' is none"
        )
    first = int(words[1])
    last = int(words[2]) if len(words) > 2 and words[2] else first
    if len(words) > 3 and numbers(model.file, line, words[3:4])[0]:
        return []
    return list(range(max(first, 1), min(last, 6) + 1))
