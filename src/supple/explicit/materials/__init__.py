"""Constitutive laws of explicit finite elements."""

from supple.explicit.materials.hardening import *
from supple.explicit.materials.j2_plasticity import *
from supple.explicit.materials.law import *
from supple.explicit.materials.neo_hookean import *
from supple.explicit.materials.st_venant_kirchhoff import *
