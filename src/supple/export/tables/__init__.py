"""Readings of a run as tables for other programs."""

from supple.export.tables.write_readings import *
