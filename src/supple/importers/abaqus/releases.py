"""Released ends of beams: *RELEASE."""

from __future__ import annotations

import numpy as np

from supple.arrays import BoolArray, IntArray
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.element_types import Family
from supple.importers.keyword_file import fields

# Freedoms of rotations about the beam axis x (T) and the section axes y (M1) and z (M2).
_ROTATIONS = {"T": (3,), "M1": (4,), "M2": (5,), "ALLM": (3, 4, 5)}
_ENDS = {"S1": 0, "S2": 6}


def read_releases(model: AbaqusModel) -> BoolArray | None:
    """Released freedoms (E, 12) of the ends of all elements of a file; None without releases.

    A line names an element or set, then one or both ends (S1, S2), each with a code (M1, M2, T, M1-M2, ..,
    ALLM).
    """
    found = np.zeros((len(model.element_labels.ids), 12), dtype=bool)
    beams = np.zeros(len(found), dtype=bool)
    for block in model.elements:
        beams[block.numbers] = block.type.family is Family.BEAM
    for placed in model.named("RELEASE"):
        for line, text in placed.block.data:
            word, *rest = (each.upper() for each in fields(text) if each)
            members = model.elements_of(placed.scope, word, line, "*RELEASE")
            pairs = list(zip(rest[::2], rest[1::2], strict=False))
            known = all(
                end in _ENDS and all(part in _ROTATIONS for part in code.split("-")) for end, code in pairs
            )
            if not pairs or len(rest) % 2 or not known or not beams[members].all():
                meaning = "only releases of S1 or S2 by M1, M2, T or ALLM are read; other ends stay connected"
                model.report.leave_out("*RELEASE", line, meaning)
                continue
            for end, code in pairs:
                for freedom in (f for part in code.split("-") for f in _ROTATIONS[part]):
                    found[members, _ENDS[end] + freedom] = True
    return found if found.any() else None


def released_ends(releases: BoolArray | None, elements: IntArray) -> BoolArray | None:
    """Released freedoms (C, 12) of cells; None without releases.

    The first cell of a quadratic beam has the first end, the last cell the second.

    elements : (C,) number of the element of each cell; cells of one element are consecutive
    """
    if releases is None or not releases[elements].any():
        return None
    found = releases[elements].copy()
    inner = elements[1:] == elements[:-1]
    found[np.append(inner, False), 6:] = False
    found[np.append(False, inner), :6] = False
    return found
