"""Which rounds were useless, and what is missed where they stall."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error.stopping import is_useless, missed_part
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import NoDerivatives, NormalModes, reduction_basis


def test_a_round_no_better_than_the_one_before_is_useless():
    assert is_useless([1.0, 0.5, 0.5])
    assert is_useless([1.0, np.inf])
    assert not is_useless([1.0])
    assert not is_useless([np.inf, 1.0])
    assert not is_useless([1.0, 0.5])


def test_a_missing_mode_is_told_by_its_frequency_and_where_it_moves_most():
    """The third mode, added to a basis of two: Rayleigh's quotient is its frequency, its tip moves most."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    body = flexible_body("arm", shell_model(strip(1.0, 0.1, 6, 2), wall), (RigidInterface("root", "root"),))
    frame = NodalFixedFrame("root")
    basis = reduction_basis(body, frame, NormalModes(3), derivatives=NoDerivatives())
    part = missed_part(FullBody(body, frame), basis, 2)
    expected = lowest_modes(body.stiffness, body.mass, 3, constraint=frame.constraint(body)).values[2]
    assert part.frequency == pytest.approx(np.sqrt(expected), rel=1e-6)
    assert part.place[0] == pytest.approx(1.0)
    assert "start with all modes up to this frequency" in part.words
