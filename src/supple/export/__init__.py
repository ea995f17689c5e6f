"""Reduced bodies for other days and other programs: one format per file."""

from supple.export.exudyn import exudyn_arrays, interface_nodes, write_exudyn
from supple.export.reduced_body_hdf5 import (
    holds_reduced_body,
    read_interface_names,
    read_reduced_body,
    write_reduced_body,
)

__all__ = [
    "exudyn_arrays",
    "holds_reduced_body",
    "interface_nodes",
    "read_interface_names",
    "read_reduced_body",
    "write_exudyn",
    "write_reduced_body",
]
