"""Damping of a case: held modes have the ratio that is asked for, or a run warns; what it shows of them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.body import MeanAxisFrame
from supple.cases.damping import Modal, Rayleigh, RayleighRatio, warn_of_ratios
from supple.errors import SuppleWarning
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, NormalModes, reduce
from supple.results.run_summary import body_numbers
from supple.results.run_tables import body_table

ASKED = RayleighRatio(kind="rayleigh-ratio", ratio=0.02, modes=(1, 3), held="root")


@pytest.fixture(scope="module")
def body():
    return beam_body("root", n=6, length=4.0)


def reduced(body, given, recipe):
    frame = MeanAxisFrame()
    return reduce(
        body.linearized(),
        frame,
        recipe,
        derivatives=NoDerivatives(),
        damping=given.build(body, frame),
        loads=NoLoads,
    )


@pytest.mark.parametrize("given", [ASKED, Modal(kind="modal", ratio=0.02, held="root")])
def test_both_kinds_act_against_the_interface_that_they_name(body, given):
    assert given.build(body, MeanAxisFrame()).held == "root"
    found = reduced(body, given, CraigBampton(6))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_ratios(given, found)


@pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")
def test_a_basis_that_lacks_the_held_modes_is_warned_of(body):
    """Three free modes, without static shapes: the third held mode of such a body is far too fast."""
    found = reduced(body, ASKED, NormalModes(3))
    with pytest.warns(
        SuppleWarning, match=r"2 % is given for its modes 1 and 3 with 'root' clamped; the reduced body has"
    ):
        warn_of_ratios(ASKED, found)


def test_of_a_damping_against_the_frame_nothing_is_asked(body):
    given = ASKED.model_copy(update={"held": None})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_ratios(given, reduced(body, given, CraigBampton(6)))
        warn_of_ratios(
            Rayleigh(kind="rayleigh", alpha=1.0, beta=0.0, held="root"), reduced(body, ASKED, CraigBampton(6))
        )
        warn_of_ratios(None, reduced(body, ASKED, CraigBampton(6)))


def test_a_run_shows_the_ratios_of_held_modes_beside_their_frequencies(body):
    numbers = body_numbers(reduced(body, ASKED, CraigBampton(6)))
    np.testing.assert_allclose(np.array(numbers["damping ratios held"]["root"])[[0, 2]], 0.02, rtol=1e-3)
    table = body_table({"units": {}, "bodies": {"beams": numbers}})
    assert table.heads[-1] == "damping ratios, %"
    assert [row[-1].split()[:1] for row in table.rows] == [[], ["2"]]
    undamped = body_numbers(
        reduce(
            body.linearized(), MeanAxisFrame(), CraigBampton(6), derivatives=NoDerivatives(), loads=NoLoads
        )
    )
    assert "damping ratios held" not in undamped
    assert "damping ratios, %" not in body_table({"units": {}, "bodies": {"beams": undamped}}).heads
