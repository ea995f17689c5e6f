"""The page on the layout of result files names the format's version, columns and every field of a motion."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest

from supple.integrate import FloatingMotion
from supple.methods.explicit import NodalMotion
from supple.methods.intrinsic import IntrinsicMotion
from supple.storage.result_content import FORMAT, N_COLUMNS, TEXTS, VERSION

PAGE = (Path(__file__).parents[2] / "docs/how-to/result_file.md").read_text("utf-8")


def test_the_page_is_of_the_version_that_is_written():
    assert f'`format = "{FORMAT}"`, `version = {VERSION}`' in PAGE
    assert f"| `commits` | (k, {N_COLUMNS}) |" in PAGE
    assert set(TEXTS) <= set(re.findall(r"^\| `(\w+)` \| text", PAGE, re.MULTILINE))


@pytest.mark.parametrize("motion", [FloatingMotion, IntrinsicMotion, NodalMotion])
def test_the_page_names_every_field_of_a_motion(motion):
    assert f"`{motion.kind}`" in PAGE
    assert {field.name for field in fields(motion)} <= set(re.findall(r"`(\w+)`", PAGE))
