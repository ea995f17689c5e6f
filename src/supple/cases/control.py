"""The controllers of a case, created by a function in a Python file, which runs only if allowed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from supple.errors import CaseError
from supple.importers.toml import Mistakes, Raw
from supple.machine import Controller, SampledController, System

_FORM = 'control = "controller.py:function"'


def controllers_of(
    control: str | None, system: System, folder: Path, *, allow_code: bool
) -> tuple[Controller | SampledController, ...]:
    """The controllers that the function of a case creates for its machine; none without a function.

    control : "FILE.py:FUNCTION"; the function takes the system, and returns one controller or several

    Raises
    ------
    CaseError   code that is not allowed to run, is missing or fails, or returns something else
    """
    if control is None:
        return ()
    check_code_allowed(control, allow_code=allow_code)
    name, _, function = control.partition(":")
    path = folder / name
    try:
        made = getattr(_module(path, path.read_bytes()), function)(system)
    except Exception as error:  # any error of a user's program
        raise CaseError(
            f"{_at(control)} fails: {type(error).__name__}: {error}; correct the function"
        ) from error
    every: Sequence[object] = made if isinstance(made, list | tuple) else (made,)
    for each in every:
        if not isinstance(each, Controller | SampledController):
            raise CaseError(
                f"{_at(control)} must return a Controller or a SampledController, or a list; it returned a "
                f"{type(each).__name__}"
            )
    return tuple(every)


def check_code_allowed(control: str | None, *, allow_code: bool) -> None:
    """Raise CaseError if a case has code that is not allowed to run."""
    if control is not None and not allow_code:
        raise CaseError(
            f"{_at(control)} runs arbitrary Python code on this computer: read it, then give --allow-code "
            "(in Python, allow_code=True)"
        )


@lru_cache(maxsize=8)
def _module(path: Path, source: bytes) -> ModuleType:
    """The module of a file, loaded once, so that its functions are the same objects in all cases."""
    module = ModuleType(f"control_of_{path.stem}")
    module.__file__ = str(path)
    exec(compile(source, path, "exec"), vars(module))
    return module


def control_file(control: object) -> str | None:
    """The file name in a value of `control`."""
    return control.partition(":")[0] if isinstance(control, str) else None


def _at(control: str) -> str:
    return f'control = "{control}"'


def _names_file_and_function(raw: Raw) -> Mistakes:
    control = raw.get("control")
    if isinstance(control, str):
        file, _, function = control.partition(":")
        if not (file.endswith(".py") and function.isidentifier()):
            yield ("control",), f"{control!r} is not FILE.py:FUNCTION; write {_FORM}"


RULES = (_names_file_and_function,)
