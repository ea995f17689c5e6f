"""Reduced bodies and machines for other codes, one format per file."""

from supple.export.exudyn import (
    exudyn_arrays,
    interface_nodes,
    write_exudyn,
)

__all__ = [
    "exudyn_arrays",
    "interface_nodes",
    "write_exudyn",
]
