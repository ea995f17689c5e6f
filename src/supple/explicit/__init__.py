"""Explicit march: modal parts on four-point frames beside nonlinear finite elements."""

from supple.explicit.elements import BulkViscosity as BulkViscosity
from supple.explicit.engine import *
from supple.explicit.explicit_shell import *
from supple.explicit.explicit_subdomain import *
from supple.explicit.march.model import *
from supple.explicit.materials import J2Plasticity as J2Plasticity
from supple.explicit.materials import LinearHardening as LinearHardening
from supple.explicit.materials import NeoHookean as NeoHookean
from supple.explicit.materials import PowerHardening as PowerHardening
from supple.explicit.materials import StVenantKirchhoff as StVenantKirchhoff
from supple.explicit.method import *
from supple.explicit.modal_subdomain import *
from supple.explicit.motions import *
from supple.explicit.projected_difference import *
from supple.explicit.published_scheme import *
from supple.explicit.spin_stiffness import *
