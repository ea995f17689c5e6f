"""Reports as JSON files."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from supple.storage.atomic_write import replacing

__all__ = ["write_json"]


def write_json(path: Path | str, data: Any) -> Path:
    """Write nested mappings, sequences, dataclasses, numbers, strings and arrays as a JSON file, atomically.

    A number that is not finite, which JSON cannot represent, becomes null.

    Raises
    ------
    TypeError           a value of another kind
    ResultFileError     the file cannot be written
    """
    text = json.dumps(_plain(data), indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return Path(path)


def _plain(value: Any) -> Any:
    match value:
        case np.ndarray() | np.generic():
            return _plain(value.tolist())
        case float() if not math.isfinite(value):
            return None
        case Mapping():
            return {str(key): _plain(item) for key, item in value.items()}
        case list() | tuple():
            return [_plain(item) for item in value]
        case None | bool() | int() | float() | str():
            return value
        case _ if is_dataclass(value) and not isinstance(value, type):
            return _plain(asdict(value))
        case _:
            raise TypeError(f"a report cannot hold a {type(value).__name__}: give numbers, strings or arrays")
