"""Self-correcting reduction, and error estimates of finished runs."""

from supple.error.basis_error import *
from supple.error.batch_estimate import *
from supple.error.case_indicator import *
from supple.error.correction_folder import *
from supple.error.correction_rounds import *
from supple.error.equilibrium_correction import *
from supple.error.error_estimate import *
from supple.error.error_study import *
from supple.error.recorded_correction import *
from supple.error.residual_correction import *
from supple.error.round_archive import *
from supple.error.round_table import *
from supple.error.self_correction import *
