"""Dual coupling of sub-domains at rest in space: multipliers on velocities, several time steps."""

from supple.explicit.coupling.chosen_scheme import *
from supple.explicit.coupling.dual_march import *
from supple.explicit.coupling.interface_operator import *
from supple.explicit.coupling.multi_time_step import *
from supple.explicit.coupling.sides import *
