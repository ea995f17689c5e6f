"""The machine of the tests on units, ids and pictures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from fixtures.arm_on_a_hub import write_machine


@pytest.fixture
def machine(tmp_path) -> Callable[..., Path]:
    """Writes the machine into a folder of that name, in some units; returns the case file."""
    return lambda folder, units, **given: write_machine(tmp_path / folder, units, **given)
