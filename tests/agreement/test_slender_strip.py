"""One slender strip through the full model, a floating frame, several in a chain, and intrinsic modes.

At rest under a dead tip force, against the elastica; errors are shares of the deflection of the tip.
"""

import pytest

from supple_benchmarks.intrinsic.agreement import tip_by

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("method", ["full", "floating", "split", "intrinsic"])
def test_all_methods_agree_while_the_strip_bends_little(method):
    """0.1 rad."""
    assert tip_by(method, 0.1)["error"] < 3e-3


@pytest.mark.filterwarnings("ignore::supple.errors.BasisWarning")  # of the floating basis
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # its rotation is what is tested
def test_only_intrinsic_modes_hold_where_the_tip_turns_far():
    """1.2 rad: beyond the kinematics of one floating frame."""
    intrinsic, floating = tip_by("intrinsic", 1.2)["error"], tip_by("floating", 1.2)["error"]
    assert intrinsic < 2e-3
    assert floating is None or intrinsic < floating / 5  # None: no equilibrium at all
