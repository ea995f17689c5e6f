"""Names of the channels of a case, before its bodies are reduced."""

from __future__ import annotations

from supple.body import FullBody
from supple.cases.case import Case
from supple.cases.result_tables import recorded_quantities
from supple.sweeps.group_bodies import is_reduced_here

__all__ = ["planned_channels"]


def planned_channels(case: Case) -> tuple[str, ...]:
    """Names of all channels of a case, such as "joint root.Fx", in their order.

    Bodies to be reduced are replaced by full bodies: their meshes are read, but no matrix is factored.
    Raises SuppleError for errors of meshes, bodies, joints or sensors.
    """
    full = {
        table.name: FullBody(case.flexible[table.name], table.frame.build())
        for table in case.parts.body
        if is_reduced_here(table) and table.frame is not None
    }
    planned = case.varied(case.tables, full)
    return tuple(
        f"{quantity.name}.{channel.name}" if channel.name else quantity.name
        for quantity in recorded_quantities(planned, planned.system)
        for channel in quantity.channels(planned.system)
    )
