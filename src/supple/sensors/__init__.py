"""Sensors: numbers read off a motion as an instrument on the machine would, each with its unit and axes."""

from supple.sensors.element_energy_sensor import *
from supple.sensors.energy_sensor import *
from supple.sensors.force_sensors import *
from supple.sensors.joint_motion_sensor import *
from supple.sensors.over_nodes import *
from supple.sensors.place_sensors import *
from supple.sensors.reading import *
from supple.sensors.section_sensor import *
from supple.sensors.sensor import *
from supple.sensors.stress_sensor import *
