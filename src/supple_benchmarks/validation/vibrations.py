"""Frequencies of beams, plates and solids: at rest, rotating, and under compressive loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from supple.body import FlexibleBody, FullBody, MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.fem import FiniteElementModel, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.linearization import linearize, machine_modes
from supple.machine import GROUND, At, DeadForce, Fixed, FollowerForce, Placed, Spin, System
from supple.machine.system import Load
from supple.mesh import CellType, block, plate
from supple.reduction import CompressedDerivatives, CraigBampton, reduce
from supple_benchmarks.lines import BENDING_ROOTS, line_mesh, points_along_x
from supple_benchmarks.validation.beam_chain import rectangle
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, compared, matched

__all__ = ["CASES"]

Array = NDArray[np.float64]

RAYLEIGH = "Euler-Bernoulli beam: Lord Rayleigh, Theory of Sound, chapter VIII"


def _frequencies(system: System, n_modes: int, spin: Spin | None = None) -> Array:
    """The lowest angular frequencies about the machine's equilibrium, rad/s, ascending."""
    return machine_modes(linearize(system, spin=spin), n_modes).frequencies


def _clamped(body: FlexibleBody, *loads: Load) -> System:
    wall = Fixed(name="wall", first=GROUND, second=At(body.name, "root"))
    return System([Placed(FullBody(body, NodalFixedFrame("root")))], [wall], loads)


def _beam(n: int = 64, *, y: float = 0.03, z: float = 0.01) -> FlexibleBody:
    """A slender beam of 1 m along x with n elements, section y by z, m; its soft bending direction is z."""
    nodes = points_along_x(1, n)
    model = shell_model(line_mesh(nodes), rectangle(STEEL, y, z, _torsion(y, z), orientation=(0, 1, 0)))
    return flexible_body("beam", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def _torsion(y: float, z: float) -> float:
    return y * z**3 / 3 * (1 - 0.63 * z / y)


STEEL = Isotropic(2.1e11, 0.0, 7800.0)
WAVE = np.sqrt(STEEL.youngs_modulus / STEEL.density)


def cantilever() -> Sequence[Comparison]:
    """Frequencies of a beam of line elements: bending in both planes, torsion and extension."""
    y, z = 0.03, 0.01
    found = _frequencies(_clamped(_beam()), 24)
    weak, strong = (WAVE * size / np.sqrt(12) * np.square(BENDING_ROOTS) for size in (z, y))
    twist = (
        np.pi
        / 2
        * np.sqrt(STEEL.youngs_modulus / 2 * _torsion(y, z) / (STEEL.density * (y * z**3 + z * y**3) / 12))
    )
    waves = "closed form: waves in a bar"
    expected = [(f"bending {k + 1}, rad/s", weak[k], RAYLEIGH, 2e-3) for k in range(3)]
    expected += [("bending of the stiff plane, rad/s", strong[0], RAYLEIGH, 2e-3)]
    expected += [("torsion, rad/s", twist, waves, 2e-3), ("stretching, rad/s", WAVE * np.pi / 2, waves, 2e-3)]
    return [
        Comparison(name, own, value, source, allowed)
        for own, (name, value, source, allowed) in zip(
            matched(found, [value for _, value, *_ in expected]), expected, strict=True
        )
    ]


def solid_beam() -> Sequence[Comparison]:
    """A cantilever of quadratic bricks."""
    length, height = 1.0, 0.02
    body = _body("beam", solid_model(block(length, height, height, 24, 1, 1, CellType.HEXA20), STEEL), "root")
    found = _frequencies(_clamped(body), 6)
    exact = WAVE * height / np.sqrt(12) * np.square(BENDING_ROOTS[:3])
    return compared((f"bending {k}, rad/s" for k in (1, 2, 3)), found[::2], exact, RAYLEIGH, 5e-3)


def _body(name: str, model: FiniteElementModel, held: str) -> FlexibleBody:
    return flexible_body(name, model, (RigidInterface("root", held),))


ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)


def plates() -> Sequence[Comparison]:
    """A thin square plate of shells: clamped along all edges, clamped along one edge, and free."""
    side, thickness, n = 1.0, 0.005, 12
    bending = ALUMINIUM.youngs_modulus * thickness**3 / 12 / (1 - 0.3**2)
    unit = np.sqrt(bending / (ALUMINIUM.density * thickness)) / side**2
    model = shell_model(plate(side, side, n, n), HomogeneousSection(ALUMINIUM, thickness))
    around = _frequencies(_clamped(_body("plate", model, "boundary")), 1) / unit
    along = _frequencies(_clamped(_body("plate", model, "x_min")), 3) / unit
    free = _frequencies(System([FullBody(flexible_body("plate", model, ()), MeanAxisFrame())]), 9) / unit
    ritz = "thin-plate theory, Poisson's ratio 0.3: Ritz's method, 10 Legendre polynomials in each direction"
    unit_of = "w a^2 sqrt(rho h / D)"
    found = [around[0], *along[:2], *free[free > 1][:3]]
    edges = ("clamped all around", "clamped along an edge, first", "clamped along an edge, second")
    names = [f"{each}, {unit_of}" for each in (*edges, "free, first", "free, second", "free, third")]
    return compared(names, found, (35.985, 3.471, 8.508, 13.468, 19.596, 24.270), ritz, 0.01)


def spinning_beam() -> Sequence[Comparison]:
    """A slender cantilever, full and reduced, that rotates about its root at 6 sqrt(E I / (m L^4))."""
    y = z = 0.01
    unit = WAVE * z / np.sqrt(12)
    body = _beam(y=y, z=z)
    full = _clamped(body)
    reduced = reduce(
        body, NodalFixedFrame("root"), CraigBampton(n_modes=8), derivatives=CompressedDerivatives(12)
    )
    spin = Spin(6 * unit, axis=np.array([0.0, 0.0, 1.0]))
    turned = {
        "full": _frequencies(full, 6, spin) / unit,
        "reduced": _frequencies(replace(full, bodies=[Placed(reduced)]), 6, spin) / unit,
    }
    source = "A. D. Wright et al., J. Appl. Mech. 49 (1982) 197-202, table 1"
    flaps = (7.3604, 26.8091)
    lag = float(np.sqrt(flaps[0] ** 2 - 36))
    rows = []
    for name, found in turned.items():
        values = matched(found, [*flaps, lag])
        rows += [
            Comparison(f"flapping 1, {name}, over sqrt(EI/(m L^4))", values[0], flaps[0], source, 3e-3),
            Comparison(f"flapping 2, {name}, over sqrt(EI/(m L^4))", values[1], flaps[1], source, 3e-3),
            Comparison(
                f"lag 1, {name}, over sqrt(EI/(m L^4))", values[2], lag, f"{source}: flap^2 - spin^2", 3e-3
            ),
        ]
    return rows


def pressed_beam() -> Sequence[Comparison]:
    """The first frequency of a clamped-free column under half of Euler's load."""
    z = 0.01
    bending = STEEL.youngs_modulus * 0.03 * z**3 / 12
    load = np.pi**2 / 8 * bending
    found = _frequencies(_clamped(_beam(), DeadForce(body="beam", at="tip", force=(-load, 0, 0))), 1)[0]
    unit = WAVE * z / np.sqrt(12)

    def determinant(w: float) -> float:
        """Boundary determinant of u'''' + p u'' - w^2 u = 0: clamped; u'' = u''' + p u' = 0 at the tip.

        p = P L^2 / E I;  w over sqrt(E I / (m L^4))
        """
        p = load / bending
        a, b = (np.sqrt(np.sqrt(p**2 / 4 + w**2) + sign * p / 2) for sign in (1, -1))
        moments = b**2 * np.cosh(b) + a**2 * np.cos(a), b**2 * np.sinh(b) + a * b * np.sin(a)
        forces = a * b * (a * np.sinh(b) - b * np.sin(a)), b * (a**2 * np.cosh(b) + b**2 * np.cos(a))
        return moments[0] * forces[1] - moments[1] * forces[0]

    exact = brentq(determinant, 1.0, 3.5)
    return (
        Comparison(
            "first frequency under half of Euler's load, rad/s",
            found,
            float(exact) * unit,
            "S. P. Timoshenko, D. H. Young, Vibration Problems in Engineering: beam under axial load",
            2e-3,
        ),
    )


def beck() -> Sequence[Comparison]:
    """Beck's column: flutter under a compressive follower force at the tip.

    At the critical force the two lowest squared frequencies coincide. The square of their difference is a
    smooth function of the force and passes through zero there: it is extrapolated from four smaller forces.
    """
    y, z = 0.1, 0.01
    body = reduce(
        _beam(y=y, z=z),
        NodalFixedFrame("root"),
        CraigBampton(n_modes=10),
        derivatives=CompressedDerivatives(20),
    )
    unit = STEEL.youngs_modulus * y * z**3 / 12
    wall = Fixed(name="wall", first=GROUND, second=At("beam", "root"))
    loads = np.array([14.0, 16.0, 18.0, 19.5])
    squares = []
    for load in loads:
        push = FollowerForce(first=At("beam", "tip"), force=(-load * unit, 0, 0))
        squares.append(_frequencies(System([Placed(body)], [wall], [push]), 2) ** 2)
    apart, mean = np.diff(squares).ravel() ** 2, np.mean(squares, axis=1)
    critical = CubicSpline(loads, apart).roots()
    critical = float(critical[critical > loads[-1]][0])
    flutter = float(np.sqrt(CubicSpline(loads, mean)(critical))) / (WAVE * z / np.sqrt(12))
    source = "M. Beck, Z. angew. Math. Phys. 3 (1952) 225-228: 20.05 E I / L^2, w L^2 sqrt(m / E I) = 11.02"
    return (
        Comparison("critical force, P L^2 / E I", critical, 20.051, source, 5e-3),
        Comparison("frequency of the flutter, w L^2 sqrt(m / E I)", flutter, 11.016, source, 5e-3),
    )


CASES = (
    ValidationCase("spinning beam", spinning_beam),
    ValidationCase("cantilever of beam elements", cantilever),
    ValidationCase("cantilever of quadratic bricks", solid_beam),
    ValidationCase("square plates", plates),
    ValidationCase("column under half of Euler's load", pressed_beam, quick=False),
    ValidationCase("Beck's column", beck, quick=False),
)
