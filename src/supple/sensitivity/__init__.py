"""Derivatives of run results with respect to parameters of a machine, and fits to measured motion."""

from supple.sensitivity.calibrate import *
from supple.sensitivity.calibration import *
from supple.sensitivity.measurement import *
from supple.sensitivity.observable import *
from supple.sensitivity.sensitivities import *
