"""Selection of the one body of a case to write."""

from __future__ import annotations

from collections.abc import Sequence

from supple.cases import Case
from supple.errors import CaseError, did_you_mean


def chosen_body(case: Case, names: Sequence[str] | None, known: Sequence[str], kind: str, none: str) -> str:
    """The body with the given name, or the only one.

    known : bodies that can be written
    kind : description of these bodies
    none : remedy if there are no such bodies

    Raises CaseError for several names, an unknown name, the name of a split body, or no name where there are
    several bodies.
    """
    listed = ", ".join(known) or "none"
    if names and len(names) > 1:
        raise CaseError(f"{case.path}: only one body can be written, and {len(names)} are given: give one")
    if not names and len(known) == 1:
        return known[0]
    if not names:
        remedy = "give one: --body NAME" if known else none
        raise CaseError(f"{case.path} has {len(known)} {kind} ({listed}); {remedy}")
    parts = case.names_in_machine(names)
    if parts != list(names):
        raise CaseError(
            f"{case.path}: split divides body '{names[0]}' into {', '.join(parts)}; give one of these "
            "parts, or remove split"
        )
    if names[0] not in known:
        raise CaseError(
            f"{case.path}: '{names[0]}' is none of the {kind}{did_you_mean(names[0], list(known))}"
        )
    return names[0]
