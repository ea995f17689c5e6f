"""TOML files as checked tables: what a schema and rules find wrong, all at once, each with its line."""

from supple.importers.toml.checked_table import *
from supple.importers.toml.line_index import *
from supple.importers.toml.mistakes import *
from supple.importers.toml.raw_tables import *
