from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.viz import plot_eigenvalue_error

ERRORS = np.geomspace(1e-6, 1e-3, 30)


def test_errors_at_several_steps_and_the_exact_ones(tmp_path, ink):
    few = np.where(np.arange(30) < 20, 30 * ERRORS, np.inf)
    path = plot_eigenvalue_error(
        tmp_path / "errors.png", {20: few, 60: ERRORS}, 1e-3, exact={60: 0.95 * ERRORS}
    )
    assert path == tmp_path / "errors.png"
    assert 0.01 < ink(path) < 0.5


@pytest.mark.parametrize("errors", [np.full(5, np.inf), np.zeros(5)])
def test_errors_that_cannot_be_drawn(tmp_path, errors):
    with pytest.raises(ModelError, match="error '7 modes' is nowhere positive and finite"):
        plot_eigenvalue_error(tmp_path / "errors.png", {7: errors}, 1e-3)
    with pytest.raises(ModelError, match="at least one number of modes"):
        plot_eigenvalue_error(tmp_path / "errors.png", {}, 1e-3)
