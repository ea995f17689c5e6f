"""Numbers as tables show them."""

import numpy as np

from supple.results import without_noise


def test_noise_and_negative_zeros_are_shown_as_zero():
    shown = [f"{each:.5g}" for each in (*without_noise([1.0, -1e-12]), *without_noise(np.array([-0.0, 0.0])))]
    assert shown == ["1", "0", "0", "0"]
