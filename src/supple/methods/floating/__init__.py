"""Floating-frame equations of motion, compiled for reduced bodies and sparse for full ones."""

from supple.methods.floating.compiled.engine import *
from supple.methods.floating.compiled.kinematics import *
from supple.methods.floating.compiled.statics import *
from supple.methods.floating.full.engine import *
from supple.methods.floating.full.kinematics import *
from supple.methods.floating.full.statics import *
