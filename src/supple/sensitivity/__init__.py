"""Derivatives of what a run gives for numbers of its machine, and numbers fitted to measured motion."""

from supple.sensitivity.calibrate import *
from supple.sensitivity.calibration import *
from supple.sensitivity.measurement import *
from supple.sensitivity.observable import *
from supple.sensitivity.sensitivities import *
