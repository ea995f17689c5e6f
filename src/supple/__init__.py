"""Reduced-order flexible multibody dynamics: reduced finite-element bodies, with estimates of their error.

    import supple as sp

provides the names that most scripts need, in the order of the workflow:

    mesh -> model -> body -> reduction -> machine -> run -> correction -> results -> files -> pictures

All other names are in the sub-packages. The sub-package of a name is loaded when the name is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from supple import errors as errors

if TYPE_CHECKING:  # the same names as in _NAMES, for editors and type checkers
    from supple.body import AveragingInterface as AveragingInterface
    from supple.body import FullBody as FullBody
    from supple.body import MeanAxisFrame as MeanAxisFrame
    from supple.body import ModalDamping as ModalDamping
    from supple.body import NodalFixedFrame as NodalFixedFrame
    from supple.body import RayleighDamping as RayleighDamping
    from supple.body import RigidBody as RigidBody
    from supple.body import RigidInterface as RigidInterface
    from supple.body import flexible_body as flexible_body
    from supple.cases import read_case as read_case
    from supple.error import ErrorStudy as ErrorStudy
    from supple.error import ReductionStart as ReductionStart
    from supple.error import SelfCorrection as SelfCorrection
    from supple.error import self_correct as self_correct
    from supple.error import state_errors as state_errors
    from supple.export import write_vtkhdf as write_vtkhdf
    from supple.export import write_vtu as write_vtu
    from supple.fatigue import damage_equivalent_load as damage_equivalent_load
    from supple.fatigue import rainflow as rainflow
    from supple.fem import HomogeneousSection as HomogeneousSection
    from supple.fem import Isotropic as Isotropic
    from supple.fem import shell_model as shell_model
    from supple.fem import solid_model as solid_model
    from supple.importers import read_abaqus as read_abaqus
    from supple.importers import read_gmsh as read_gmsh
    from supple.importers import read_mesh as read_mesh
    from supple.importers import read_nastran as read_nastran
    from supple.integrate import AdaptiveStep as AdaptiveStep
    from supple.integrate import FixedStep as FixedStep
    from supple.integrate import GeneralizedAlpha as GeneralizedAlpha
    from supple.integrate import Run as Run
    from supple.integrate import Tolerances as Tolerances
    from supple.linearization import linearize as linearize
    from supple.linearization import machine_modes as machine_modes
    from supple.machine import GROUND as GROUND
    from supple.machine import At as At
    from supple.machine import Ball as Ball
    from supple.machine import BaseAcceleration as BaseAcceleration
    from supple.machine import Cylindrical as Cylindrical
    from supple.machine import DeadForce as DeadForce
    from supple.machine import DeadTorque as DeadTorque
    from supple.machine import Fixed as Fixed
    from supple.machine import FollowerForce as FollowerForce
    from supple.machine import FollowerPressure as FollowerPressure
    from supple.machine import FollowerTorque as FollowerTorque
    from supple.machine import Placed as Placed
    from supple.machine import PrescribedRotation as PrescribedRotation
    from supple.machine import PrescribedTranslation as PrescribedTranslation
    from supple.machine import Prismatic as Prismatic
    from supple.machine import Ramp as Ramp
    from supple.machine import Revolute as Revolute
    from supple.machine import Sine as Sine
    from supple.machine import Spin as Spin
    from supple.machine import SpinUp as SpinUp
    from supple.machine import Spline as Spline
    from supple.machine import SpringDamper as SpringDamper
    from supple.machine import System as System
    from supple.machine import Table as Table
    from supple.machine import TorsionSpringDamper as TorsionSpringDamper
    from supple.machine import Turning as Turning
    from supple.machine import Universal as Universal
    from supple.machine import read_mujoco as read_mujoco
    from supple.machine import split_body as split_body
    from supple.mesh import CellType as CellType
    from supple.mesh import Mesh as Mesh
    from supple.mesh import block as block
    from supple.mesh import cylinder as cylinder
    from supple.mesh import skin_of as skin_of
    from supple.mesh import strip as strip
    from supple.methods.explicit import explicit_subdomain as explicit_subdomain
    from supple.methods.explicit import modal_subdomain as modal_subdomain
    from supple.methods.intrinsic import LoadPath as LoadPath
    from supple.methods.intrinsic import condense as condense
    from supple.progress import show_progress as show_progress
    from supple.quantities import node_positions as node_positions
    from supple.quantities import stress_modes as stress_modes
    from supple.reduction import AttachmentModes as AttachmentModes
    from supple.reduction import CompressedDerivatives as CompressedDerivatives
    from supple.reduction import CraigBampton as CraigBampton
    from supple.reduction import ErrorControlled as ErrorControlled
    from supple.reduction import NoDerivatives as NoDerivatives
    from supple.reduction import NoLoads as NoLoads
    from supple.reduction import PickedDerivatives as PickedDerivatives
    from supple.reduction import Rubin as Rubin
    from supple.reduction import SteadyLoads as SteadyLoads
    from supple.reduction import reduce as reduce
    from supple.report import player as player
    from supple.report import write_report as write_report
    from supple.results import rms_error as rms_error
    from supple.sensitivity import Measurement as Measurement
    from supple.sensitivity import calibrate as calibrate
    from supple.sensitivity import sensitivities as sensitivities
    from supple.simulation import Start as Start
    from supple.simulation import equilibrium as equilibrium
    from supple.simulation import simulate as simulate
    from supple.simulation import simulate_batch as simulate_batch
    from supple.stepping import step_program as step_program
    from supple.storage import read_reduced_body as read_reduced_body
    from supple.storage import read_solution as read_solution
    from supple.storage import write_reduced_body as write_reduced_body
    from supple.sweeps import case_parameters as case_parameters
    from supple.sweeps import read_sweep as read_sweep
    from supple.sweeps import sweep as sweep
    from supple.viz import animate as animate
    from supple.viz import displacement_magnitude as displacement_magnitude
    from supple.viz import plot_contour as plot_contour
    from supple.viz import plot_mesh as plot_mesh
    from supple.viz import stress_field as stress_field

__version__ = "0.1.0"

_NAMES = {
    "supple.mesh": "Mesh CellType strip block cylinder skin_of",
    "supple.importers": "read_mesh read_abaqus read_gmsh read_nastran",
    "supple.fem": "Isotropic HomogeneousSection shell_model solid_model",
    "supple.body": (
        "RigidInterface AveragingInterface flexible_body RigidBody FullBody "
        "MeanAxisFrame NodalFixedFrame RayleighDamping ModalDamping"
    ),
    "supple.reduction": (
        "reduce CraigBampton Rubin AttachmentModes SteadyLoads NoLoads ErrorControlled "
        "CompressedDerivatives PickedDerivatives NoDerivatives"
    ),
    "supple.machine": (
        "System Placed At GROUND "
        "Fixed Ball Revolute Universal Cylindrical Prismatic PrescribedRotation PrescribedTranslation "
        "SpringDamper TorsionSpringDamper DeadForce DeadTorque FollowerForce FollowerTorque "
        "FollowerPressure BaseAcceleration split_body read_mujoco "
        "Table Spline Ramp Sine SpinUp Turning Spin"
    ),
    "supple.integrate": "Run FixedStep AdaptiveStep GeneralizedAlpha Tolerances",
    "supple.methods.intrinsic": "condense LoadPath",
    "supple.methods.explicit": "modal_subdomain explicit_subdomain",
    "supple.progress": "show_progress",
    "supple.simulation": "simulate simulate_batch equilibrium Start",
    "supple.linearization": "linearize machine_modes",
    "supple.sensitivity": "sensitivities calibrate Measurement",
    "supple.stepping": "step_program",
    "supple.error": "self_correct SelfCorrection ReductionStart state_errors ErrorStudy",
    "supple.results": "rms_error",
    "supple.report": "write_report player",
    "supple.quantities": "node_positions stress_modes",
    "supple.fatigue": "rainflow damage_equivalent_load",
    "supple.cases": "read_case",
    "supple.storage": "read_solution read_reduced_body write_reduced_body",
    "supple.export": "write_vtkhdf write_vtu",
    "supple.sweeps": "sweep read_sweep case_parameters",
    "supple.viz": "plot_mesh plot_contour animate displacement_magnitude stress_field",
}
"""Public names by sub-package, separated by spaces."""

_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        from difflib import get_close_matches

        close = get_close_matches(name, _HOMES, n=1)
        raise AttributeError(
            f"module 'supple' has no attribute '{name}'" + (f"; did you mean '{close[0]}'?" if close else "")
        )
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "errors", "__version__"]
