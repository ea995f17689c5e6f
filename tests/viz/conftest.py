"""Pictures are checked for what a reader needs: they are there, and something is on them."""

import numpy as np
import pytest
from PIL import Image

from supple.viz import contour, mesh_plot, shaded_surface, style


@pytest.fixture(autouse=True)
def _coarse_pictures(monkeypatch):
    """A sixteenth of the pixels: what is looked for here is as large in them."""
    monkeypatch.setattr(shaded_surface, "_SUPERSAMPLING", 1)
    monkeypatch.setitem(style._RC, "savefig.dpi", 100)
    for module in (contour, mesh_plot):
        monkeypatch.setattr(module, "N_COLUMNS", 630)


@pytest.fixture
def ink():
    """Share of a picture's pixels that are not white."""

    def measure(path):
        with Image.open(path) as picture:
            pixels = np.asarray(picture.convert("RGB"))
        return float((pixels.min(axis=2) < 250).mean())

    return measure
