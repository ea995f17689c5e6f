"""Systems of bodies, joints and loads; floating-frame equations of motion, reduced and full."""

from supple.multibody.batch import BatchSolution, simulate_batch
from supple.multibody.energy import Balances, balances
from supple.multibody.full_body import FullBody
from supple.multibody.joints import (
    GROUND,
    At,
    Ball,
    Cylindrical,
    Fixed,
    Joint,
    JointFrame,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    Universal,
)
from supple.multibody.loads import (
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerTorque,
    ForceElement,
    SpringDamper,
    TorsionSpringDamper,
)
from supple.multibody.residual_correction import ResidualCorrections, residual_corrections
from supple.multibody.self_correction import (
    Round,
    SelfCorrected,
    SelfCorrection,
    SelfCorrectionError,
    self_correct,
)
from supple.multibody.simulate import Checkpoint, simulate
from supple.multibody.system import Placed, System
from supple.multibody.time_law import Constant, Table, TimeFunction, TimeLaw
from supple.multibody.validity import Validity

__all__ = [
    "GROUND",
    "At",
    "Balances",
    "Ball",
    "BatchSolution",
    "Checkpoint",
    "Constant",
    "Cylindrical",
    "DeadForce",
    "DeadTorque",
    "Fixed",
    "FollowerForce",
    "FollowerTorque",
    "ForceElement",
    "FullBody",
    "Joint",
    "JointFrame",
    "Placed",
    "PrescribedRotation",
    "PrescribedTranslation",
    "Prismatic",
    "ResidualCorrections",
    "Revolute",
    "Round",
    "SelfCorrected",
    "SelfCorrection",
    "SelfCorrectionError",
    "SpringDamper",
    "System",
    "Table",
    "TimeFunction",
    "TimeLaw",
    "TorsionSpringDamper",
    "Universal",
    "Validity",
    "balances",
    "residual_corrections",
    "self_correct",
    "simulate",
    "simulate_batch",
]
