"""Explicit march: modal sub-domains on four-point frames beside nonlinear finite elements."""

from supple.explicit.collocated import Collocated
from supple.explicit.continuity import EveryNode, MeanMotion
from supple.explicit.elements import BulkViscosity
from supple.explicit.engine import ENERGIES, OBSTACLES, STEPS, ExplicitEngine, ExplicitOptions
from supple.explicit.explicit_shell import ExplicitShell, explicit_shell
from supple.explicit.explicit_subdomain import ExplicitSubdomain, explicit_subdomain
from supple.explicit.explicit_system import (
    Contact,
    ExplicitSystem,
    NodalForce,
    Part,
    Support,
    SurfaceContact,
    Tie,
)
from supple.explicit.march.model import Energies
from supple.explicit.materials import (
    J2Plasticity,
    LinearHardening,
    NeoHookean,
    PowerHardening,
    StVenantKirchhoff,
)
from supple.explicit.modal_subdomain import ModalSubdomain, modal_subdomain
from supple.explicit.mortar import Mortar
from supple.explicit.motions import FourPointMotion, NodalMotion
from supple.explicit.obstacles import RigidCylinder, RigidPlane, RigidSphere
from supple.explicit.positions import part_positions
from supple.explicit.projected_difference import ProjectedDifference
from supple.explicit.published_scheme import (
    ExactLinks,
    LaggedGyroscopicForce,
    NoGyroscopicForce,
    PredictedLinks,
    PublishedScheme,
)
from supple.explicit.simulate_explicit import keep_explicit, simulate_explicit
from supple.explicit.spin_stiffness import CentrifugalStiffness

__all__ = [
    "ENERGIES",
    "OBSTACLES",
    "STEPS",
    "BulkViscosity",
    "CentrifugalStiffness",
    "Collocated",
    "Contact",
    "Energies",
    "EveryNode",
    "ExactLinks",
    "ExplicitEngine",
    "ExplicitOptions",
    "ExplicitShell",
    "ExplicitSubdomain",
    "ExplicitSystem",
    "FourPointMotion",
    "J2Plasticity",
    "LaggedGyroscopicForce",
    "LinearHardening",
    "MeanMotion",
    "ModalSubdomain",
    "Mortar",
    "NeoHookean",
    "NoGyroscopicForce",
    "NodalForce",
    "NodalMotion",
    "Part",
    "PowerHardening",
    "PredictedLinks",
    "ProjectedDifference",
    "PublishedScheme",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "StVenantKirchhoff",
    "Support",
    "SurfaceContact",
    "Tie",
    "explicit_shell",
    "explicit_subdomain",
    "keep_explicit",
    "modal_subdomain",
    "part_positions",
    "simulate_explicit",
]
