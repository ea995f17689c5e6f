"""Sensors: numbers read off a motion as an instrument on the machine would, each with its unit and axes."""

from supple.sensors.element_energy_sensor import ElementEnergySensor
from supple.sensors.energy_sensor import EnergySensor
from supple.sensors.force_sensors import JointForceSensor, SpringForceSensor
from supple.sensors.joint_motion_sensor import JointMotionSensor
from supple.sensors.over_nodes import Maximum, Mean, Nearest, OverNodes
from supple.sensors.place_sensors import (
    AccelerationSensor,
    AngularVelocitySensor,
    DeflectionSensor,
    Place,
    PositionSensor,
    VelocitySensor,
)
from supple.sensors.reading import Located, Reading, as_dataset, write_readings, write_readings_hdf5
from supple.sensors.section_sensor import SectionForceSensor
from supple.sensors.sensor import Channel, LocatedSensor, Quantity, Sensor, read_sensors
from supple.sensors.stress_sensor import (
    Component,
    Principal,
    StrainSensor,
    StressSensor,
    TensorMeasure,
    VonMises,
)

__all__ = [
    "AccelerationSensor",
    "AngularVelocitySensor",
    "Channel",
    "Component",
    "DeflectionSensor",
    "ElementEnergySensor",
    "EnergySensor",
    "JointForceSensor",
    "JointMotionSensor",
    "Located",
    "LocatedSensor",
    "Maximum",
    "Mean",
    "Nearest",
    "OverNodes",
    "Place",
    "PositionSensor",
    "Principal",
    "Quantity",
    "Reading",
    "SectionForceSensor",
    "Sensor",
    "SpringForceSensor",
    "StrainSensor",
    "StressSensor",
    "TensorMeasure",
    "VelocitySensor",
    "VonMises",
    "as_dataset",
    "read_sensors",
    "write_readings",
    "write_readings_hdf5",
]
