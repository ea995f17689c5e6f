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
from supple.multibody.compiled.engine import CompiledEngine
from supple.multibody.compiled.kinematics import KinematicEngine
from supple.multibody.compiled.statics import CompiledStatics
from supple.multibody.equations.static_search import StaticSearch
from supple.multibody.full.engine import FullEngine
from supple.multibody.full.statics import FullStatics

__all__ = [
    "Balances",
    "BandCoverage",
    "CompiledEngine",
    "CompiledStatics",
    "FullEngine",
    "FullStatics",
    "KinematicEngine",
    "LoadSpectrum",
    "StaticSearch",
    "balances",
    "band_coverage",
    "joint_residuals",
    "load_spectra",
    "warn_of_missing_modes",
]
