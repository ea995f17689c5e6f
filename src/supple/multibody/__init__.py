"""Floating-frame equations of motion, compiled for reduced bodies and sparse for full ones."""

from supple.multibody.checks.energy import (
    Balances,
    balances,
)
from supple.multibody.checks.joint_residuals import (
    joint_residuals,
)
from supple.multibody.checks.load_spectrum import (
    BandCoverage,
    LoadSpectrum,
    band_coverage,
    load_spectra,
    warn_of_missing_modes,
)
from supple.multibody.checks.validity import (
    Validity,
)
from supple.multibody.run_parts import (
    Checkpoint,
)

__all__ = [
    "Balances",
    "BandCoverage",
    "Checkpoint",
    "LoadSpectrum",
    "Validity",
    "balances",
    "band_coverage",
    "joint_residuals",
    "load_spectra",
    "warn_of_missing_modes",
]
