"""Attachment modes beside any modes: interface statics exact, the same body in every frame."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import subspace_angles

from supple.body import MeanAxisFrame
from supple.errors import ModelError
from supple.reduction import (
    AttachmentModes,
    ErrorControlled,
    NoDerivatives,
    NoLoads,
    NormalModes,
    Rubin,
    reduce,
)
from supple.reduction.bases.interface_columns import motion_rows


def test_in_a_mean_axis_frame_they_make_normal_modes_rubin_s(strip_body, mean_axis):
    mine = reduce(
        strip_body, mean_axis, AttachmentModes(NormalModes(4)), derivatives=NoDerivatives(), loads=NoLoads
    )
    rubin = reduce(strip_body, mean_axis, Rubin(n_modes=4), derivatives=NoDerivatives(), loads=NoLoads)
    np.testing.assert_allclose(mine.frequencies, rubin.frequencies, rtol=1e-8)


def test_the_same_body_in_every_frame(strip_body, mean_axis, root_frame):
    """Columns and rigid motions together span one space: a Ritz space of the free body."""
    recipe = AttachmentModes(ErrorControlled(0.01, 4))
    spans = [
        np.hstack([strip_body.rigid_modes, recipe.build(strip_body, frame).vectors])
        for frame in (mean_axis, root_frame)
    ]
    scaled = [span / np.linalg.norm(span, axis=0) for span in spans]
    assert subspace_angles(*scaled).max() < 1e-6


def test_balanced_interface_loads_are_answered_exactly(strip_body, frame):
    """Loads in balance (here: stretched, twisted and bent between two ends) deform a free body statically."""
    loads = motion_rows(strip_body.interfaces).T
    R = strip_body.rigid_modes
    balanced = loads @ np.linalg.svd(R.T @ loads)[2][6:].T  # amplitudes without resultant
    exact = strip_body.constrained(frame.constraint(strip_body)).solve(balanced)
    reduced = reduce(
        strip_body, frame, AttachmentModes(NormalModes(1)), derivatives=NoDerivatives(), loads=NoLoads
    )
    motion = np.vstack([interface.motion for interface in reduced.interfaces])
    amplitudes = np.linalg.lstsq(loads, balanced, rcond=None)[0]
    answer = reduced.nodal_basis @ np.linalg.solve(reduced.stiffness, motion.T @ amplitudes)
    expected = strip_body.expansion @ exact
    np.testing.assert_allclose(answer, expected, atol=1e-6 * np.abs(expected).max())


def test_what_was_proven_of_the_eigenvalues_stays_proven(strip_body):
    linear = strip_body.linearized()
    alone = reduce(
        linear, MeanAxisFrame(), ErrorControlled(0.05, 6), derivatives=NoDerivatives(), loads=NoLoads
    )
    both = reduce(
        linear,
        MeanAxisFrame(),
        AttachmentModes(ErrorControlled(0.05, 6)),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )
    certificate = both.report.certificate
    assert certificate is not None
    values = both.frequencies[:6] ** 2
    assert (values >= certificate.enclosure.lower * (1 - 1e-9)).all()
    assert (values <= alone.frequencies[:6] ** 2 * (1 + 1e-9)).all()


def test_body_without_interfaces_is_refused(loose_body, mean_axis):
    with pytest.raises(ModelError, match="an attachment mode needs interfaces, but body 'strip' has none"):
        AttachmentModes(NormalModes(1)).build(loose_body, mean_axis)
