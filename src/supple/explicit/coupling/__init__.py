"""Dual coupling of sub-domains at rest in space: multipliers on velocities, several time steps."""

from supple.explicit.coupling.chosen_scheme import chosen_scheme
from supple.explicit.coupling.dual_march import CoupledMotion, dual_march
from supple.explicit.coupling.interface_operator import InterfaceOperator, interface_operator
from supple.explicit.coupling.multi_time_step import GravouilCombescure, MultiTimeStep, PrakashHjelmstad
from supple.explicit.coupling.sides import Coupling, ElementSide, ModalSide

__all__ = [
    "CoupledMotion",
    "Coupling",
    "ElementSide",
    "GravouilCombescure",
    "InterfaceOperator",
    "ModalSide",
    "MultiTimeStep",
    "PrakashHjelmstad",
    "chosen_scheme",
    "dual_march",
    "interface_operator",
]
