"""Parts of long C functions as separate functions.

The time of an optimising compiler grows faster than the length of a function. The statements of a long block
are therefore divided among several functions. Variables that more than one of them reads are members of a
struct `shared`, which the whole function keeps on its stack.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

LONGEST = 3000
"""Largest number of lines of a block that is not divided."""
_LINES = 300
"""Largest number of lines of a part; a longer statement is a part by itself."""

TOKEN = re.compile(r"@(\d+)@")
"""Placeholder of a variable that has no name yet."""


def runs_of_statements(lines: Sequence[int], fixed: set[int]) -> list[range]:
    """Runs of consecutive statements for the parts of a block, in order.

    lines : number of lines of each statement
    fixed : indices of statements that leave a loop, which a function cannot do; each is a run by itself
    """
    starts, total = [0], lines[0]
    for place in range(1, len(lines)):
        total += lines[place]
        if total > _LINES or place in fixed or place - 1 in fixed:
            starts.append(place)
            total = lines[place]
    return [range(start, stop) for start, stop in zip(starts, [*starts[1:], len(lines)], strict=True)]


@dataclass
class SeparateFunctions:
    """The parts of one C function, and the variables that they share.

    name : prefix of the names at file scope
    parameters : declaration and name of each parameter of the whole function
    shared : numbers of the variables that more than one function reads
    names : C names of these variables;  members : their declarations
    """

    name: str
    parameters: Sequence[tuple[str, str]]
    shared: set[int] = field(default_factory=set)
    names: dict[int, str] = field(default_factory=dict)
    members: list[str] = field(default_factory=list)
    _bodies: list[str] = field(default_factory=list)

    def call(self, body: str) -> str:
        """Add a function with this body; returns the statement that calls it.

        A comment in the statement names the shared variables that the function uses, so that the statement
        counts as a use of their storage.
        """
        read = sorted({int(number) for number in TOKEN.findall(body)})
        self.shared |= set(read)
        self._bodies.append(body)
        given = ", ".join(["shared", *(name for _, name in self.parameters)])
        return f"{self._name(len(self._bodies) - 1)}({given}); /* {' '.join(f'@{each}@' for each in read)} */"

    def storage(self) -> str:
        """Declaration of the shared variables, for the body of the whole function; empty without parts."""
        if not self._bodies:
            return ""
        return f"struct {self.name}_shared storage, *const shared = &storage;\n"

    def text(self) -> str:
        """Definitions of the struct and the functions in C, once all shared variables have names."""
        if not self._bodies:
            return ""
        members = "".join(f"    {each}\n" for each in self.members)
        parts = [f"struct {self.name}_shared {{\n{members}    int unused;\n}};"]
        given = ", ".join([f"struct {self.name}_shared *shared", *(own for own, _ in self.parameters)])
        ignored = " ".join(f"(void){name};" for name in ("shared", *(name for _, name in self.parameters)))
        for place, body in enumerate(self._bodies):
            named = TOKEN.sub(lambda match: self.names[int(match[1])], body)
            parts.append(f"static SEPARATE void {self._name(place)}({given})\n{{\n{ignored}\n{named}\n}}")
        return "\n\n".join(parts)

    def _name(self, place: int) -> str:
        return f"{self.name}_part_{place}"
