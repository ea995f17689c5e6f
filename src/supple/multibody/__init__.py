"""Systems of bodies, joints and loads; floating-frame equations of motion, reduced and full."""

from supple.multibody.batch import BatchSolution, simulate_batch
from supple.multibody.correction_rounds import (
    CorrectedSystem,
    ReductionStart,
    Round,
    SelfCorrected,
    SelfCorrection,
    SelfCorrectionError,
)
from supple.multibody.energy import Balances, balances
from supple.multibody.full_body import FullBody
from supple.multibody.joint_gaps import joint_gaps
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
from supple.multibody.load_spectrum import (
    BandCoverage,
    LoadSpectrum,
    band_coverage,
    load_spectra,
    warn_of_missing_modes,
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
from supple.multibody.residual_correction import (
    ResidualCorrections,
    residual_corrections,
    system_corrections,
)
from supple.multibody.round_archive import MissedMotion, RoundArchive, RoundBases
from supple.multibody.run_parts import Checkpoint
from supple.multibody.self_correction import self_correct
from supple.multibody.simulate import simulate
from supple.multibody.system import Placed, System
from supple.multibody.system_correction import self_correct_system
from supple.multibody.time_law import Constant, Table, TimeFunction, TimeLaw, Turning
from supple.multibody.validity import Validity

__all__ = [
    "GROUND",
    "At",
    "Balances",
    "Ball",
    "BandCoverage",
    "BatchSolution",
    "Checkpoint",
    "Constant",
    "CorrectedSystem",
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
    "LoadSpectrum",
    "MissedMotion",
    "Placed",
    "PrescribedRotation",
    "PrescribedTranslation",
    "Prismatic",
    "ReductionStart",
    "ResidualCorrections",
    "Revolute",
    "Round",
    "RoundArchive",
    "RoundBases",
    "SelfCorrected",
    "SelfCorrection",
    "SelfCorrectionError",
    "SpringDamper",
    "System",
    "Table",
    "TimeFunction",
    "TimeLaw",
    "TorsionSpringDamper",
    "Turning",
    "Universal",
    "Validity",
    "balances",
    "band_coverage",
    "joint_gaps",
    "load_spectra",
    "residual_corrections",
    "self_correct",
    "self_correct_system",
    "simulate",
    "simulate_batch",
    "system_corrections",
    "warn_of_missing_modes",
]
