from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from supple.body import MeanAxisFrame, NodalFixedFrame, frame_projector
from supple.errors import ModelError

FRAMES = [MeanAxisFrame(), NodalFixedFrame("root"), NodalFixedFrame("tip")]


@pytest.mark.parametrize("frame", FRAMES, ids=str)
def test_what_is_seen_from_a_frame(body, frame):
    D, R = frame.constraint(body), body.rigid_modes
    project = frame_projector(body, frame)
    x = np.random.default_rng(0).standard_normal((body.n, 4))
    seen = project(x)
    # It meets the frame's conditions, differs by a rigid motion, and a second look changes nothing.
    assert np.max(np.abs(D @ seen)) < 1e-11 * np.max(np.abs(D) @ np.abs(x))
    rigid = np.linalg.lstsq(R, x - seen)[0]
    np.testing.assert_allclose(R @ rigid, x - seen, atol=1e-12)
    np.testing.assert_allclose(project(seen), seen, atol=1e-12)
    np.testing.assert_allclose(project(R), 0, atol=1e-12)
    np.testing.assert_array_equal(project(x[:, 0]), project(x[:, :1])[:, 0])


def test_nodal_fixed_holds_the_interface(body):
    motion = body.interface("root").motion
    seen = frame_projector(body, NodalFixedFrame("root"))(np.random.default_rng(1).standard_normal(body.n))
    np.testing.assert_allclose(motion @ seen, 0, atol=1e-12)


def test_mean_axis_leaves_no_momentum(body):
    # Linear momentum, and to first order angular momentum, of a motion seen from the mean-axis frame.
    rate = frame_projector(body, MeanAxisFrame())(np.random.default_rng(2).standard_normal(body.n))
    momentum = (body.nodal_mass @ (body.expansion @ rate)).reshape(len(body.nodes), body.dofs_per_node)
    angular = np.cross(body.nodes, momentum[:, :3]).sum(axis=0)
    if body.dofs_per_node == 6:
        angular += momentum[:, 3:].sum(axis=0)
    size = np.abs(momentum).sum()
    assert np.max(np.abs(momentum[:, :3].sum(axis=0))) < 1e-13 * size
    assert np.max(np.abs(angular)) < 1e-13 * size


def test_an_unknown_interface_is_named(body):
    with pytest.raises(ModelError, match="has no interface 'hub'; there are: root, tip"):
        NodalFixedFrame("hub").constraint(body)


def test_a_frame_must_hold_the_body(body):
    @dataclass(frozen=True)
    class Slack:
        def constraint(self, body):
            return np.eye(6, body.n)[[0, 0, 1, 2, 3, 4]]

    with pytest.raises(ModelError, match="does not fix the rigid motion of body"):
        frame_projector(body, Slack())
