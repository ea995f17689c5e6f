"""Sensor readings as HDF5: a dataset per sensor, with axes, places and nodes."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from supple.errors import ModelError
from supple.quantities import Readings
from supple.storage.hdf5_name import name_taken_in_hdf5
from supple.units import UnitSystem


def write_hdf5(path: Path, readings: Readings, units: UnitSystem) -> None:
    """Write `time` (t,), and for each sensor its values (t, c) with channels, units and axes as attributes.

    For a sensor at nodes, `NAME.nodes` (t, c) has the ids of the nodes. The attributes `nodes` (c,) and
    `points` (c, 3) are the id and the position of the node at which each channel has its largest magnitude.

    Raises ModelError for a name that HDF5 cannot have beside the others.
    """
    times = readings.columns(units).times
    names = [each.name for each in readings]
    for name in names:
        if reason := name_taken_in_hdf5(name, names):
            raise ModelError(f"sensor '{name}': {reason}")
    # Built in memory, because a failed write crashes HDF5: see storage/disk_space.
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
        file.create_dataset("time", data=times).attrs["unit"] = units.time
        for each in readings:
            values = file.create_dataset(each.name, data=each.values)
            values.attrs["channels"] = [channel.name for channel in each.channels]
            values.attrs["quantities"] = [channel.quantity.value for channel in each.channels]
            values.attrs["units"] = [channel.quantity.unit(units) for channel in each.channels]
            values.attrs["axes"] = [channel.axes for channel in each.channels]
            if any(channel.place for channel in each.channels):
                values.attrs["places"] = [channel.place for channel in each.channels]
            if each.nodes is not None and each.points is not None:
                channels = np.arange(len(each.channels))
                values.attrs["nodes"] = each.nodes[each.peaks, channels]
                values.attrs["points"] = each.points[each.peaks, channels]
                file.create_dataset(f"{each.name}.nodes", data=each.nodes)
        file.flush()
        path.write_bytes(file.id.get_file_image())
