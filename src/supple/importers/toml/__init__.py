"""TOML files as checked tables: what a schema and rules find wrong, all at once, each with its line."""

from supple.importers.toml.checked_table import (
    ZERO,
    CheckedTable,
    Matrix,
    NodeIndices,
    NonNegative,
    Positive,
    Vector,
)
from supple.importers.toml.line_index import KeyPath, LineIndex, index_lines
from supple.importers.toml.mistakes import checked, listed_mistakes
from supple.importers.toml.raw_tables import (
    Mistakes,
    Raw,
    Rule,
    RuleOfOne,
    did_you_mean,
    names,
    on_each,
    table,
    tables,
    unknown,
)

__all__ = [
    "ZERO",
    "CheckedTable",
    "KeyPath",
    "LineIndex",
    "Matrix",
    "Mistakes",
    "NodeIndices",
    "NonNegative",
    "Positive",
    "Raw",
    "Rule",
    "RuleOfOne",
    "Vector",
    "checked",
    "did_you_mean",
    "index_lines",
    "listed_mistakes",
    "names",
    "on_each",
    "table",
    "tables",
    "unknown",
]
