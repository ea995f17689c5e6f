"""Section tables: the reader is selected by the suffix."""

from __future__ import annotations

from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.section_csv import read_section_csv
from supple.importers.section_table import SectionTable
from supple.importers.text_file import is_file
from supple.importers.turbine.beamdyn import read_beamdyn_sections
from supple.importers.turbine.windio_sections import read_windio_sections

__all__ = ["SECTION_SUFFIXES", "is_section_file", "read_section_table"]

_READERS = {
    ".csv": read_section_csv,
    ".yaml": read_windio_sections,
    ".yml": read_windio_sections,
    ".dat": read_beamdyn_sections,
    ".inp": read_beamdyn_sections,
}
SECTION_SUFFIXES = tuple(_READERS)
_KEY_POINTS, _HEAD = b"kp_total", 1 << 14
"""Key of BeamDyn's primary file, whose suffix is also that of decks; bytes in which it is searched."""


def is_section_file(path: Path) -> bool:
    """Whether a file is to be read as a section table: by its suffix, or as the primary file of BeamDyn."""
    reader = _READERS.get(path.suffix.lower())
    if reader is not read_beamdyn_sections:
        return reader is not None
    if not is_file(path):
        return False
    with path.open("rb") as file:
        return _KEY_POINTS in file.read(_HEAD).lower()


def read_section_table(path: str | Path) -> SectionTable:
    """Section table of a file: CSV, a windIO turbine (.yaml), or the primary file of BeamDyn (.dat, .inp).

    Raises ImportFormatError and ModelError as `read_section_csv`, `read_windio_sections` and
    `read_beamdyn_sections`; ImportFormatError for another suffix.
    """
    reader = _READERS.get(Path(path).suffix.lower())
    if reader is None:
        raise ImportFormatError(
            f"{path}: not a section table; give a file {', '.join(SECTION_SUFFIXES)} (CSV, windIO, BeamDyn)"
        )
    return reader(path)
