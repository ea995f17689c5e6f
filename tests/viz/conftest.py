"""Pictures are checked for what a reader needs: they are there, and something is on them."""

import numpy as np
import pytest
from PIL import Image


@pytest.fixture
def ink():
    """Share of a picture's pixels that are not white."""

    def measure(path):
        with Image.open(path) as picture:
            pixels = np.asarray(picture.convert("RGB"))
        return float((pixels.min(axis=2) < 250).mean())

    return measure
