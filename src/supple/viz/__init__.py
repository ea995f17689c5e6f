"""Pictures: the only importer of matplotlib."""

from supple.viz.animation import Traces, animate
from supple.viz.camera import Camera
from supple.viz.campbell_plot import plot_campbell
from supple.viz.contour import plot_contour, stress_field
from supple.viz.eigenvalue_error import plot_eigenvalue_error
from supple.viz.glyphs import Glyphs, glyphs_of
from supple.viz.machine_picture import plot_machine
from supple.viz.mesh_plot import NodalField, displacement_magnitude, plot_mesh
from supple.viz.mesh_skin import Skin, skin_of
from supple.viz.mode_shapes import mode_titles, plot_mode_shapes
from supple.viz.response_errors import Response, plot_response_errors
from supple.viz.rms_error import plot_error_over_parameter, plot_rms_error
from supple.viz.run_pictures import animate_run, draw_machine, draw_run
from supple.viz.scene import Actor, Scene, scene_of
from supple.viz.self_correction import RoundErrors, plot_rounds, plot_self_correction
from supple.viz.sensor_plot import plot_readings
from supple.viz.style import PUBLISHED, REFERENCE, SOLID, Stroke
from supple.viz.time_history import Panel, Series, plot_time_history

__all__ = [
    "PUBLISHED",
    "REFERENCE",
    "SOLID",
    "Actor",
    "Camera",
    "Glyphs",
    "NodalField",
    "Panel",
    "Response",
    "RoundErrors",
    "Scene",
    "Series",
    "Skin",
    "Stroke",
    "Traces",
    "animate",
    "animate_run",
    "displacement_magnitude",
    "draw_machine",
    "draw_run",
    "glyphs_of",
    "mode_titles",
    "plot_campbell",
    "plot_contour",
    "plot_eigenvalue_error",
    "plot_error_over_parameter",
    "plot_machine",
    "plot_mesh",
    "plot_mode_shapes",
    "plot_readings",
    "plot_response_errors",
    "plot_rms_error",
    "plot_rounds",
    "plot_self_correction",
    "plot_time_history",
    "scene_of",
    "skin_of",
    "stress_field",
]
