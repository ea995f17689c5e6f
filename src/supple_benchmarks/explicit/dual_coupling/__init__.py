"""Dual coupling of two sub-domains without rotation: multipliers on interface velocities, two time steps."""

from supple_benchmarks.explicit.dual_coupling.chosen_scheme import *
from supple_benchmarks.explicit.dual_coupling.dual_march import *
from supple_benchmarks.explicit.dual_coupling.interface_operator import *
from supple_benchmarks.explicit.dual_coupling.multi_time_step import *
from supple_benchmarks.explicit.dual_coupling.sides import *
