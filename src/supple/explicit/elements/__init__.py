"""Explicit finite elements: what is constant, and the force of a block in a step."""

from supple.explicit.elements.bulk_viscosity import BulkArrays, BulkViscosity, bulk_arrays
from supple.explicit.elements.element_stress import von_mises
from supple.explicit.elements.hourglass import hourglass_vectors
from supple.explicit.elements.incidence import gathered, incidence
from supple.explicit.elements.mean_gradient import SolidPoints, solid_points
from supple.explicit.elements.shell_block import (
    LayerArrays,
    ShellBlock,
    layered_force,
    layered_von_mises,
    rest_layers,
    shell_block,
    shell_force,
    shell_von_mises,
)
from supple.explicit.elements.solid_block import BlockForce, SolidBlock, block_force, solid_block
from supple.explicit.elements.stable_step import element_limits, squashed

__all__ = [
    "BlockForce",
    "BulkArrays",
    "BulkViscosity",
    "LayerArrays",
    "ShellBlock",
    "SolidBlock",
    "SolidPoints",
    "block_force",
    "bulk_arrays",
    "element_limits",
    "gathered",
    "hourglass_vectors",
    "incidence",
    "layered_force",
    "layered_von_mises",
    "rest_layers",
    "shell_block",
    "shell_force",
    "shell_von_mises",
    "solid_block",
    "solid_points",
    "squashed",
    "von_mises",
]
