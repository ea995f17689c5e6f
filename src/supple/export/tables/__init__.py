"""Tables of sensor readings for other programs."""

from supple.export.tables.write_readings import *
