"""File names made from names of bodies: any name is allowed, and the file stays in its folder."""

from __future__ import annotations

import hashlib

__all__ = ["file_name"]

LONGEST = 150
"""Largest length of a name, bytes; file systems allow 255, and suffixes and temporary files need some."""

# Separators of folders, and characters with a special meaning on some operating system.
_QUOTED = frozenset('%/\\:*?"<>|')


def file_name(name: str) -> str:
    """The name with forbidden characters and a first dot as %XX; above `LONGEST` bytes, cut and with a hash.

    Different names give different file names; a name within the limit without such characters is unchanged.
    """
    quoted = "".join(_percent(sign) if sign in _QUOTED or not sign.isprintable() else sign for sign in name)
    if not quoted or quoted[0] == ".":
        quoted = f"%2E{quoted[1:]}" if quoted else "%"
    content = quoted.encode("utf-8", errors="surrogateescape")
    if len(content) <= LONGEST:
        return quoted
    ending = hashlib.sha256(content).hexdigest()[:16]
    return f"{content[: LONGEST - 17].decode('utf-8', errors='ignore')}%{ending}"


def _percent(sign: str) -> str:
    return "".join(f"%{byte:02X}" for byte in sign.encode("utf-8", errors="surrogatepass"))
