"""Bodies and machines for other codes, one format per file."""

from supple.export.dmig_punch import write_dmig_punch
from supple.export.exudyn import (
    exudyn_arrays,
    interface_nodes,
    write_exudyn,
)
from supple.export.static_deck import ABAQUS, CALCULIX, DeckProgram, resultant, write_static_deck
from supple.export.static_load import static_load

__all__ = [
    "ABAQUS",
    "CALCULIX",
    "DeckProgram",
    "exudyn_arrays",
    "interface_nodes",
    "resultant",
    "static_load",
    "write_dmig_punch",
    "write_exudyn",
    "write_static_deck",
]
