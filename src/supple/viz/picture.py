"""Path of a picture file, with a notebook view."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

_TYPES = {".png": "image/png", ".gif": "image/gif", ".svg": "image/svg+xml", ".jpg": "image/jpeg"}


# Before Python 3.12 the class of a path depends on the system.
_Path = Path if TYPE_CHECKING else type(Path())


class Picture(_Path):
    """Path of a picture; a notebook shows the picture, everything else uses the path."""

    def _repr_html_(self) -> str | None:
        kind = _TYPES.get(self.suffix.lower())
        if kind is None or not self.is_file():
            return None
        content = b64encode(self.read_bytes()).decode("ascii")
        return f'<img src="data:{kind};base64,{content}" alt="{escape(self.name)}" style="max-width: 100%">'
