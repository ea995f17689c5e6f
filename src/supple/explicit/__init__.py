"""Explicit march: modal parts on four-point frames beside nonlinear finite elements."""

from supple.explicit.elements import BulkViscosity
from supple.explicit.engine import ENERGIES, OBSTACLES, STEPS, ExplicitEngine
from supple.explicit.explicit_shell import ExplicitShell, explicit_shell
from supple.explicit.explicit_subdomain import ExplicitSubdomain, explicit_subdomain
from supple.explicit.march.model import Energies
from supple.explicit.materials import (
    J2Plasticity,
    LinearHardening,
    NeoHookean,
    PowerHardening,
    StVenantKirchhoff,
)
from supple.explicit.method import Explicit
from supple.explicit.modal_subdomain import ModalSubdomain, modal_subdomain
from supple.explicit.motions import FourPointMotion, NodalMotion
from supple.explicit.projected_difference import ProjectedDifference
from supple.explicit.published_scheme import (
    ExactLinks,
    LaggedGyroscopicForce,
    NoGyroscopicForce,
    PredictedLinks,
    PublishedScheme,
)
from supple.explicit.spin_stiffness import CentrifugalStiffness

__all__ = [
    "ENERGIES",
    "OBSTACLES",
    "STEPS",
    "BulkViscosity",
    "CentrifugalStiffness",
    "Energies",
    "ExactLinks",
    "Explicit",
    "ExplicitEngine",
    "ExplicitShell",
    "ExplicitSubdomain",
    "FourPointMotion",
    "J2Plasticity",
    "LaggedGyroscopicForce",
    "LinearHardening",
    "ModalSubdomain",
    "NeoHookean",
    "NoGyroscopicForce",
    "NodalMotion",
    "PowerHardening",
    "PredictedLinks",
    "ProjectedDifference",
    "PublishedScheme",
    "StVenantKirchhoff",
    "explicit_shell",
    "explicit_subdomain",
    "modal_subdomain",
]
