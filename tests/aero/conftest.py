"""The reference rotor, and a polar that can be written down: C_l = 2 pi sin(alpha), C_d constant."""

import numpy as np
import pytest

from supple.aero import Polar
from supple.importers import nrel5mw_rotor


@pytest.fixture(scope="session")
def rotor():
    return nrel5mw_rotor()


@pytest.fixture(scope="session")
def thin_airfoil():
    angle = np.radians(np.arange(-180, 181, 1.0))
    return Polar("thin", angle, 2 * np.pi * np.sin(angle), np.full(angle.size, 0.01))
