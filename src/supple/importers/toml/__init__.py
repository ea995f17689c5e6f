"""TOML files as checked tables: all mistakes by schema and rules, each with its line."""

from supple.importers.toml.line_index import *
from supple.importers.toml.mistakes import *
from supple.importers.toml.raw_tables import *
