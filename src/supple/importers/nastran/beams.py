"""Beams of a Nastran file (CBAR, CBEAM): the direction of their sections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from supple.importers.nastran.bulk_data import BulkCard
from supple.importers.nastran.grids import GridPoints
from supple.importers.nastran.properties import BeamProperty, Property
from supple.importers.plain_number import is_plain_digits

Orientation = tuple[float, float, float]

# Fields that our beams do not have: pins and offsets at either end, and warping points.
BEAM_OPTIONS = (
    (8, "a pin flag PA"),
    (9, "a pin flag PB"),
    *((10 + i, f"an offset W{i % 3 + 1}{'AB'[i // 3]}") for i in range(6)),
    (16, "a warping point SA"),
    (17, "a warping point SB"),
)


def beam_orientation(card: BulkCard, grids: GridPoints, ends: NDArray[np.int64]) -> Orientation:
    """Unit vector in plane 1 of a beam, in basic axes: towards grid G0, or (X1, X2, X3) in the CD axes of GA.

    Raises
    ------
    ImportFormatError   no orientation, or one along the beam; a flag that gives the fields another meaning
    """
    flag = card.word(7)
    if flag not in ("", "GGG"):
        raise card.error(
            f"the flag OFFT is {flag}; only GGG is read: write the orientation in the axes of GA"
        )
    start, end = grids.positions[ends]
    pointed_at = orientation_grid(card)
    if pointed_at is not None:
        (other,) = grids.numbers(card, [pointed_at])
        vector = grids.positions[other] - start
    else:
        vector = grids.axes[ends[0]] @ [card.real(4 + i, f"X{i + 1}", 0.0) for i in range(3)]
    chord = end - start
    if not np.linalg.norm(np.cross(chord, vector)) > 1e-6 * np.linalg.norm(chord) * np.linalg.norm(vector):
        raise card.error(
            "its orientation (X1 X2 X3, or G0) is missing, or along the beam; give one across it"
        )
    vector = (
        np.round(vector / np.linalg.norm(vector), 12) + 0.0
    )  # no negative zeros, which would be another key
    return tuple(vector.tolist())


def orientation_grid(card: BulkCard) -> int | None:
    """Id of the grid G0 that a beam's section points at; None where a vector is given."""
    if is_plain_digits(card.word(4)) and not card.word(5) and not card.word(6):
        return card.integer(4, "the grid G0")
    return None


def of_beams(given: Property, orientation: Orientation | None) -> Property:
    """The property with the orientation of the beams made of it; others as they are."""
    if isinstance(given, BeamProperty) and orientation is not None:
        return replace(given, orientation=orientation)
    return given
