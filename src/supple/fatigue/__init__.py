"""Fatigue of histories: rainflow counts, damage-equivalent loads, damage by S-N curves, lifetimes."""

from supple.fatigue.cycle_count import *
from supple.fatigue.equivalent_load import *
from supple.fatigue.lifetime import *
from supple.fatigue.sn_curve import *
