"""Constitutive laws of explicit finite elements."""

from supple.explicit.materials.hardening import Hardening, LinearHardening, PowerHardening
from supple.explicit.materials.j2_plasticity import J2Plasticity
from supple.explicit.materials.law import Law, Response
from supple.explicit.materials.neo_hookean import NeoHookean
from supple.explicit.materials.st_venant_kirchhoff import StVenantKirchhoff

__all__ = [
    "Hardening",
    "J2Plasticity",
    "Law",
    "LinearHardening",
    "NeoHookean",
    "PowerHardening",
    "Response",
    "StVenantKirchhoff",
]
