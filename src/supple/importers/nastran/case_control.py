"""Case control of a Nastran file: the sets and matrices that the solution uses."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from supple.importers.plain_number import is_plain_digits

_COMMAND = re.compile(r"\s*([A-Z][A-Z0-9]*)\s*(?:\([^)]*\))?\s*=\s*(.+?)\s*$", re.IGNORECASE)
_TEMPERATURE = re.compile(r"\s*TEMP(?:E[A-Z]*)?\s*(?:\((?!LOAD)[^)]*\))?\s*=\s*(\d+)", re.IGNORECASE)
_SUBCASE = re.compile(r"\s*SUBCASE\b", re.IGNORECASE)
_OF_THE_BODY = ("SPC", "MPC", "NSM", "K2GG", "M2GG", "B2GG", "K2PP", "M2PP", "B2PP")


@dataclass(frozen=True)
class CaseControl:
    """Selections of case control, each of the first subcase that has one.

    present : whether the file has case control: CEND, or a command that is read
    chosen  : {command: value as written, in upper case}
    varied  : commands with another selection in a later subcase, or with none in the first
    temperature : id of the first temperature set for materials; an empty string without one
    """

    present: bool
    chosen: Mapping[str, str]
    varied: tuple[str, ...]
    temperature: str = ""

    def number(self, command: str) -> int | None:
        """Id of the set that a command selects; None if it selects none, or a value that is no id."""
        word = self.chosen.get(command, "")
        return int(word) if is_plain_digits(word) else None


def read_case_control(above: Sequence[str]) -> CaseControl:
    """The selections that affect a body, from the lines above the cards."""
    chosen: dict[str, str] = {}
    varied: dict[str, None] = {}
    after_cend = False
    subcases = 0
    own: set[str] = set()
    for text in above:
        subcases += _SUBCASE.match(text) is not None
        after_cend = after_cend or text.strip().upper() == "CEND"
        match = _COMMAND.match(text)
        command = match[1].upper() if match else ""
        if not match or command not in _OF_THE_BODY:
            continue
        value = match[2].upper()
        if subcases == 1 and command not in own:  # replaces the selection above all subcases
            own.add(command)
            chosen[command] = value
        was_absent = subcases > 1 and command not in chosen
        if chosen.setdefault(command, value) != value or was_absent:
            varied[command] = None
    heated = (match for text in above if (match := _TEMPERATURE.match(text)))
    temperature = next((match[1] for match in heated), "")
    return CaseControl(after_cend or bool(chosen), chosen, tuple(varied), temperature)
