"""When iterations of the error equation count as converged."""

from __future__ import annotations

import numpy as np
import pytest

from supple.error import converged_error
from supple.error.converged_error import converged


class Equation:
    """Each iteration changes the differences by the same amount."""

    def again(self, found, tangents):
        return found + 1

    def histories(self, found):
        return {"body": found}


@pytest.mark.parametrize(
    ("large", "change", "accepted"), [(False, 0.1, 0.1), (True, 0.1, np.inf), (True, 0.01, 0.01)]
)
def test_a_large_error_that_still_changes_by_a_tenth_is_not_known(monkeypatch, large, change, accepted):
    """A strip pushed within a period of its first mode: 0.06 m after three iterations, 0.3 mm in truth."""
    monkeypatch.setattr(converged_error, "is_large", lambda history: large)
    monkeypatch.setattr(converged_error, "is_finite", lambda histories: True)
    monkeypatch.setattr(converged_error, "_change", lambda first, again: change)
    found, _, changes = converged(Equation(), 0, {"body": 0})
    assert changes == {"body": accepted}
    assert (found == 0) == np.isinf(accepted)
