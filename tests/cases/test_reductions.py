"""The reduction table of a case means the recipe that a script would give, and progress is told in words."""

from __future__ import annotations

import numpy as np
import pytest

from supple.cases import read_case
from supple.cases.reductions import ErrorControlledTable
from supple.reduction import (
    AttachmentModes,
    CouplingMoment,
    CraigBampton,
    CraigBamptonResidual,
    EffectiveInterfaceMass,
    ErrorControlled,
    Guyan,
    Herting,
    NormalModes,
    Rubin,
    SearchStep,
    SteadyLoads,
)
from supple.reduction.bases.error_controlled import SMALLEST_TOLERANCE

CONTROLLED = 'basis = "error-controlled", tolerance = 1e-2, modes = 7'


def reduction_table(case_folder, keys):
    """The checked table of `reduction = { keys }` in the case of the strip."""
    path = case_folder / "strip.toml"
    start, _, rest = path.read_text().partition("reduction = ")
    path.write_text(f"{start}reduction = {{ {keys} }}{rest[rest.index(chr(10)) :]}")
    return read_case(path).tables.body[0].reduction


@pytest.mark.parametrize(
    ("keys", "recipe"),
    [
        ('basis = "rubin", modes = 7', Rubin(7)),
        ('basis = "normal-modes", modes = 7', NormalModes(7)),
        ('basis = "guyan"', Guyan()),
        ('basis = "herting", modes = 7', Herting(7)),
        ('basis = "craig-bampton-residual", modes = 0', CraigBamptonResidual(0)),
        ('basis = "craig-bampton", modes = 7', CraigBampton(7)),
        ('basis = "craig-bampton"', CraigBampton(5)),
        (
            'basis = "craig-bampton", modes = 7, select = "coupling-moment"',
            CraigBampton(7, selection=CouplingMoment(35)),
        ),
        (
            'basis = "craig-bampton", modes = 7, select = "effective-interface-mass", candidates = 9',
            CraigBampton(7, selection=EffectiveInterfaceMass(9)),
        ),
        (CONTROLLED, AttachmentModes(ErrorControlled(1e-2, 7))),
        (f"{CONTROLLED}, attachment_modes = false", ErrorControlled(1e-2, 7)),
    ],
)
def test_a_table_means_a_recipe(case_folder, keys, recipe):
    """With the static answers to steady motion besides, where modes are counted."""
    expected = SteadyLoads(recipe) if "modes = " in keys and "error-controlled" not in keys else recipe
    assert reduction_table(case_folder, keys).recipe() == expected
    if expected != recipe:
        assert reduction_table(case_folder, f"{keys}, steady = false").recipe() == recipe


def test_a_search_tells_how_far_it_has_come(case_folder):
    told: list[str] = []
    table = reduction_table(case_folder, f"{CONTROLLED}, attachment_modes = false")
    recipe = table.recipe(told.append)
    for errors in ([0.5, np.inf], [0.02, 0.0456]):
        recipe.progress(SearchStep(12, np.array(errors), 1e-2, "SharperBound", 0.1))
    assert told == ["12 modes, too few", "12 modes, error 4.6 %"]


def test_the_smallest_tolerance_is_that_of_the_search():
    keys = ErrorControlledTable.model_json_schema()["properties"]
    assert keys["tolerance"]["minimum"] == SMALLEST_TOLERANCE
