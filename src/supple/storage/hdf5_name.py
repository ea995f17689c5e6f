"""Names that sensors can have side by side in an HDF5 file."""

from __future__ import annotations

from collections.abc import Sequence


def name_taken_in_hdf5(name: str, names: Sequence[str]) -> str | None:
    """Reason for which a sensor cannot have its name in an HDF5 file beside all names, or None."""
    if name == "time":
        return "the HDF5 file of the sensors has the output times under the name time; give another name"
    if not name.strip("/"):
        return "in HDF5, / separates groups; give another name"
    above = next((other for other in names if name.startswith(f"{other}/")), None)
    if above is not None:
        return (
            f"in HDF5, / separates groups: its name lies below that of sensor '{above}'; rename one of them"
        )
    return None
