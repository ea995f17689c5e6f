"""Constraint modes: static, with a unit motion at one interface freedom and none at the others."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from scipy import linalg

from supple.body import MeanAxisFrame
from supple.errors import ModelError
from supple.reduction import CraigBampton, Guyan, NoDerivatives, NoLoads, reduce
from supple.reduction.bases.interface_columns import motion_rows


def test_constraint_modes_move_one_interface_freedom_and_need_forces_only_there(strip_body, frame):
    basis = Guyan().build(strip_body, frame)
    root, tip = (motion_rows([interface]) for interface in strip_body.interfaces)
    np.testing.assert_allclose(tip @ basis.vectors, np.eye(6), atol=1e-9)
    np.testing.assert_allclose(root @ basis.vectors, 0.0, atol=1e-9)
    forces = strip_body.stiffness @ basis.vectors
    both = np.vstack([root, tip])
    at_interfaces = both.T @ np.linalg.lstsq(both.T, forces, rcond=None)[0]
    np.testing.assert_allclose(forces, at_interfaces, atol=1e-9 * np.abs(forces).max())


def test_static_answer_to_balanced_interface_loads_is_exact(strip_body, frame):
    """Balanced, because an unbalanced load makes a mean-axis body accelerate, which is not statics."""
    B = motion_rows(strip_body.interfaces)
    loads = linalg.null_space((B @ strip_body.rigid_modes).T)
    exact = strip_body.constrained(frame.constraint(strip_body))
    reduced = reduce(strip_body, frame, Guyan(), derivatives=NoDerivatives(), loads=NoLoads)
    motion = np.vstack([interface.motion for interface in reduced.interfaces])
    answer = motion @ np.linalg.solve(reduced.stiffness, motion.T @ loads)
    expected = B @ exact.solve(B.T @ loads)
    np.testing.assert_allclose(answer, expected, atol=1e-8 * np.abs(expected).max())


def test_modes_of_the_carried_interface_are_not_formed_but_named(strip_body, frame):
    basis = Guyan().build(strip_body, frame)
    assert basis.labels == tuple(f"constraint tip {m}" for m in ("ux", "uy", "uz", "rx", "ry", "rz"))
    assert basis.dropped == tuple(f"constraint root {m}" for m in ("ux", "uy", "uz", "rx", "ry", "rz"))


def test_body_without_interfaces_is_refused(loose_body, mean_axis):
    with pytest.raises(ModelError, match="constraint modes needs interfaces, but body 'strip' has none"):
        Guyan().build(loose_body, mean_axis)


def test_a_body_whose_interfaces_hold_all_its_freedoms():
    """One beam with both nodes as interfaces: its free-body frequencies are those of its matrices."""
    body = beam_body("root", "tip", n=1)
    with pytest.raises(ModelError, match=r"has 0 modes .* keep at most 0, or use the basis \"guyan\""):
        reduce(body, MeanAxisFrame(), CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    small = reduce(body, MeanAxisFrame(), Guyan(), derivatives=NoDerivatives(), loads=NoLoads)
    assert small.r == 6
    exact = linalg.eigh(body.stiffness.toarray(), body.mass.toarray(), eigvals_only=True)[6:]
    assert small.frequencies == pytest.approx(np.sqrt(exact), rel=1e-6)
