"""What a simulation tells: recovery, tracked motion, joint loads, error measures, stress."""

from supple.body import node_displacements as node_displacements
from supple.results.error_measures import *
from supple.results.joint_loads import *
from supple.results.recovery import *
from supple.results.round_off import *
from supple.results.run_summary import *
from supple.results.stress_history import *
from supple.results.stress_modes import *
from supple.results.tracked_motion import *
