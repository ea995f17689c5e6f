"""Self-correcting reduction: rounds, missing motion, the error estimate."""

from supple.correction.basis_error import (
    BasisError,
    BodyError,
)
from supple.correction.batch_estimate import estimate_batch_errors, state_batch_errors
from supple.correction.correction_folder import (
    CorrectionFolder,
)
from supple.correction.correction_rounds import (
    CorrectedSystem,
    ReductionStart,
    Round,
    SelfCorrected,
    SelfCorrection,
    SelfCorrectionError,
)
from supple.correction.error_estimate import (
    ErrorEstimate,
    ErrorEstimator,
    estimate_error,
)
from supple.correction.error_study import ErrorStudy, state_errors
from supple.correction.judged_quantity import Deflection, JointForce, JudgedQuantity, WholeBody
from supple.correction.recorded_correction import (
    ROUNDS_FOLDER,
    correct_recorded,
)
from supple.correction.residual_correction import (
    ResidualCorrections,
    residual_corrections,
    system_corrections,
)
from supple.correction.round_archive import (
    MissedMotion,
    RoundArchive,
    RoundBases,
)
from supple.correction.round_table import (
    best_round,
    correction_numbers,
)
from supple.correction.self_correction import (
    self_correct,
)
from supple.correction.static_correction import (
    Missed,
    StaticallyCorrected,
    correct_at_rest,
    correct_statically,
    missed_at_rest,
)

__all__ = [
    "ROUNDS_FOLDER",
    "BasisError",
    "BodyError",
    "CorrectedSystem",
    "CorrectionFolder",
    "Deflection",
    "ErrorEstimate",
    "ErrorEstimator",
    "ErrorStudy",
    "JointForce",
    "JudgedQuantity",
    "Missed",
    "MissedMotion",
    "ReductionStart",
    "ResidualCorrections",
    "Round",
    "RoundArchive",
    "RoundBases",
    "SelfCorrected",
    "SelfCorrection",
    "SelfCorrectionError",
    "StaticallyCorrected",
    "WholeBody",
    "best_round",
    "correct_at_rest",
    "correct_recorded",
    "correct_statically",
    "correction_numbers",
    "estimate_batch_errors",
    "estimate_error",
    "missed_at_rest",
    "residual_corrections",
    "self_correct",
    "state_batch_errors",
    "state_errors",
    "system_corrections",
]
