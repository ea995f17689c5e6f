"""Simulation of a machine: one case, many cases, runs recorded in files."""

from supple.simulation.batch import *
from supple.simulation.batch_solution import *
from supple.simulation.engines import *
from supple.simulation.equilibrium import *
from supple.simulation.machine_assembly import *
from supple.simulation.place_error import *
from supple.simulation.recorded_run import *
from supple.simulation.simulate import *
from supple.simulation.start import *
from supple.simulation.stored_bodies import *
from supple.simulation.stored_run import *
