"""All cases of the validation, by topic."""

from __future__ import annotations

from importlib import import_module

from supple_benchmarks.validation.validation_case import ValidationCase

__all__ = ["CASES", "TOPICS"]

TOPICS = (
    "driven_starts",
    "intrinsic_lines",
    "section_tables",
    "flying_spaghetti",
    "rotors",
    "damping",
    "rest_and_modes",
    "readings",
    "error_statements",
    "explicit_impact",
    "explicit_joints",
    "rigid_machines",
    "rigid_rotation",
    "beams_at_rest",
    "vibrations",
    "condensed_models",
    "elements_at_rest",
    "sections_and_cells",
    "decks",
    "flexible_motion",
    "machine_elements",
)
"""Files of this folder that end in `CASES`, in the order of the table."""

CASES: tuple[ValidationCase, ...] = tuple(
    case for topic in TOPICS for case in import_module(f"{__package__}.{topic}").CASES
)
