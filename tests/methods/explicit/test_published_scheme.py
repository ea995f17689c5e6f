"""The source's scheme, with the errors it has (docs/theory/explicit.md)."""

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.spinning_box import flown, modal_box, rigid_box, spinning

from supple.methods.explicit.frame_model import link_residual
from supple.methods.explicit.projected_difference import ProjectedDifference
from supple.methods.explicit.published_scheme import ExactLinks, LaggedGyroscopicForce, PublishedScheme
from supple_benchmarks.explicit.free_flight import angular_momentum

TURN = 5.8e-3
TURNS = 5


def _momentum_lost(box, scheme, turn=TURN):
    spin = 0.02 * modal_box().frequencies[0] * jnp.array([0.0, 0.0, 1.0])
    step = turn / float(spin[2])
    model, state = spinning(box, scheme, step, spin)
    L = angular_momentum(model, state, step)
    change = []
    for _ in range(20):
        state = flown(scheme, model, state, step, round(2 * np.pi * TURNS / turn / 20))
        change.append(float(jnp.linalg.norm(angular_momentum(model, state, step) - L) / jnp.linalg.norm(L)))
    return max(change), np.abs(link_residual(state.p, model.squared_lengths)).max() / box.points.arm**2


def test_predicted_links_brake_a_rigid_rotation_as_derived():
    lost, links = _momentum_lost(rigid_box(), PublishedScheme())
    per_turn = -np.log(1 - lost) / TURNS
    assert per_turn == pytest.approx(2 * np.pi * TURN, rel=0.25)  # the brake slows with the rotation
    assert lost == pytest.approx(1 - (1 + 4 * np.pi * TURNS * TURN) ** -0.5, rel=1e-3)
    assert links < 1e-8


@pytest.mark.slow
def test_exact_links_do_not_brake_a_rigid_rotation():
    lost, links = _momentum_lost(rigid_box(), PublishedScheme(links=ExactLinks()))
    assert lost < 1e-11
    assert links < 1e-14


@pytest.mark.slow
def test_each_published_form_errs_more_than_the_default():
    box = modal_box()
    default, _ = _momentum_lost(box, ProjectedDifference())
    lagged, _ = _momentum_lost(box, PublishedScheme(ExactLinks(), LaggedGyroscopicForce()))
    without, _ = _momentum_lost(box, PublishedScheme(ExactLinks()))
    assert default < 1e-11 < lagged < without < 1e-3


@pytest.mark.slow
def test_the_brake_shrinks_with_the_step():
    box = modal_box()
    coarse, _ = _momentum_lost(box, PublishedScheme())
    fine, _ = _momentum_lost(box, PublishedScheme(), TURN / 4)
    assert fine < coarse / 2
