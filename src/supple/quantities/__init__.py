"""Quantities read from a machine: sensors, tracked places, stress, and quantities of interest."""

from supple.quantities.contact_force import *
from supple.quantities.control_sensor import *
from supple.quantities.end_motion import *
from supple.quantities.force_sensors import *
from supple.quantities.nodal_damage import *
from supple.quantities.over_nodes import *
from supple.quantities.place import *
from supple.quantities.place_sensors import *
from supple.quantities.quantity import *
from supple.quantities.quantity_of_interest import *
from supple.quantities.reading import *
from supple.quantities.section_sensors import *
from supple.quantities.stress_history import *
from supple.quantities.stress_sensor import *
from supple.quantities.tensor_modes import *
from supple.quantities.tracked_motion import *
