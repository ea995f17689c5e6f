"""Published benchmarks, redone: each prints our numbers beside the paper's."""

from supple.benchmark.beam_motion import BeamMotion, fly_beam, spin_up_beam
from supple.benchmark.beam_statics import bend_beam
from supple.benchmark.planar_beam import ROTATING_BEAM, BeamElements, PlanarBeam
from supple.machine.laws.spin_up import SpinUp

__all__ = [
    "ROTATING_BEAM",
    "BeamElements",
    "BeamMotion",
    "PlanarBeam",
    "SpinUp",
    "bend_beam",
    "fly_beam",
    "spin_up_beam",
]
