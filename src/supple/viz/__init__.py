"""Pictures and animations; no other subpackage imports matplotlib."""

from importlib.util import find_spec

if not (find_spec("matplotlib") and find_spec("PIL")):
    raise ImportError(
        "supple.viz needs matplotlib and pillow, which are not installed: pip install 'supple[plot]'"
    )

from supple.results.camera import *
from supple.results.camera import View as View
from supple.results.film import Film as Film
from supple.results.film import RotorAngle as RotorAngle
from supple.viz.animation import *
from supple.viz.campbell_plot import *
from supple.viz.contour import *
from supple.viz.error_curves import *
from supple.viz.glyphs import *
from supple.viz.mesh_plot import *
from supple.viz.mode_shapes import *
from supple.viz.response_errors import *
from supple.viz.rest_and_mode_pictures import *
from supple.viz.run_animation import *
from supple.viz.run_curves import plot_readings as plot_readings
from supple.viz.run_pictures import *
from supple.viz.scene import *
from supple.viz.self_correction import *
from supple.viz.style import *
from supple.viz.time_history import *
