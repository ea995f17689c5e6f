"""Names of bodies as parts of names of files: whatever a body is called, its files lie in their folder."""

from __future__ import annotations

import hashlib

__all__ = ["file_name"]

LONGEST = 150
"""Bytes; a file system takes 255, of which the rest is for endings and for temporary files."""

# What separates folders or means something to a system that users share files with.
_QUOTED = frozenset('%/\\:*?"<>|')


def file_name(name: str) -> str:
    """The name with what no file name may hold as %XX; a longer one ends in a hash of all of it.

    Different names stay different, and an ordinary one is itself.
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
