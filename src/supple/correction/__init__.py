"""Self-correcting reduction: rounds, missing motion, the error estimate."""

from supple.correction.basis_error import *
from supple.correction.batch_estimate import *
from supple.correction.correction_folder import *
from supple.correction.correction_rounds import *
from supple.correction.error_estimate import *
from supple.correction.error_study import *
from supple.correction.judged_quantity import *
from supple.correction.recorded_correction import *
from supple.correction.residual_correction import *
from supple.correction.round_archive import *
from supple.correction.round_table import *
from supple.correction.self_correction import *
from supple.correction.static_correction import *
