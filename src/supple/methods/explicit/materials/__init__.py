"""Constitutive laws of explicit finite elements."""

from supple.methods.explicit.materials.elastic_laws import *
from supple.methods.explicit.materials.hardening import *
from supple.methods.explicit.materials.j2_plasticity import *
from supple.methods.explicit.materials.law import *
