"""Machines linearised about an equilibrium: modes, state space, frequency response, Campbell diagram.

`linearize` returns a `LinearMachine`, or a `SparseMachine` for full bodies; `machine_modes` computes its
modes.
"""

from supple.linearization.base_motion import *
from supple.linearization.campbell import *
from supple.linearization.frequency_response import *
from supple.linearization.linear_machine import *
from supple.linearization.linearize import *
from supple.linearization.machine_modes import *
from supple.linearization.mode_motion import *
from supple.linearization.mode_names import *
from supple.linearization.ports import *
from supple.linearization.sparse_machine import *
from supple.linearization.state_space import *
from supple.linearization.whirl import *
