"""Explicit time integration: modal parts on four-point frames, coupled to nonlinear finite elements.

A modal part (`ModalSubdomain`) is a linear body with vibration modes on a frame of four points at fixed
distances. An explicit part has finite elements of solids or shells; its coordinates are the displacements of
its nodes. Ties connect nodes of one part to another part. A rigid body is a frame without modes.
"""

from supple.methods.explicit.elements import BulkViscosity as BulkViscosity
from supple.methods.explicit.engine import *
from supple.methods.explicit.explicit_shell import *
from supple.methods.explicit.explicit_subdomain import *
from supple.methods.explicit.march.march_model import *
from supple.methods.explicit.materials import J2Plasticity as J2Plasticity
from supple.methods.explicit.materials import LinearHardening as LinearHardening
from supple.methods.explicit.materials import NeoHookean as NeoHookean
from supple.methods.explicit.materials import PowerHardening as PowerHardening
from supple.methods.explicit.materials import StVenantKirchhoff as StVenantKirchhoff
from supple.methods.explicit.method import *
from supple.methods.explicit.modal_subdomain import *
from supple.methods.explicit.motions import *
from supple.methods.explicit.projected_difference import *
from supple.methods.explicit.published_scheme import *
from supple.methods.explicit.spin_stiffness import *
