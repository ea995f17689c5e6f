"""Sweeps: many variants of one case file, run in parallel and stored in one folder."""

from supple.sweeps.case_parameters import *
from supple.sweeps.case_table import *
from supple.sweeps.certified_group import *
from supple.sweeps.executors import *
from supple.sweeps.fatigue_loads import *
from supple.sweeps.over_seeds import *
from supple.sweeps.plan import *
from supple.sweeps.read_sweep import *
from supple.sweeps.run_share import *
from supple.sweeps.sobol_indices import *
from supple.sweeps.sweep_file import *
from supple.sweeps.sweep_report import *
from supple.sweeps.sweep_status import *
from supple.sweeps.swept_group import *

# isort: split
# Last, because its function has the name of its module.
from supple.sweeps.sweep import *
