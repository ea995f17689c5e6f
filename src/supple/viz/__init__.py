"""Pictures: the only importer of matplotlib."""

from supple.viz.animation import animate
from supple.viz.camera import Camera
from supple.viz.mesh_plot import NodalField, displacement_magnitude, plot_mesh
from supple.viz.mesh_skin import Skin, skin_of
from supple.viz.mode_shapes import plot_mode_shapes
from supple.viz.rms_error import plot_error_over_parameter, plot_rms_error
from supple.viz.style import PUBLISHED, REFERENCE, SOLID, Stroke
from supple.viz.time_history import Panel, Series, plot_time_history

__all__ = [
    "PUBLISHED",
    "REFERENCE",
    "SOLID",
    "Camera",
    "NodalField",
    "Panel",
    "Series",
    "Skin",
    "Stroke",
    "animate",
    "displacement_magnitude",
    "plot_error_over_parameter",
    "plot_mesh",
    "plot_mode_shapes",
    "plot_rms_error",
    "plot_time_history",
    "skin_of",
]
