"""Constitutive laws of explicit finite elements."""

from supple.methods.explicit.materials.hardening import *
from supple.methods.explicit.materials.j2_plasticity import *
from supple.methods.explicit.materials.law import *
from supple.methods.explicit.materials.neo_hookean import *
from supple.methods.explicit.materials.st_venant_kirchhoff import *
