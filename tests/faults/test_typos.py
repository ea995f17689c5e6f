"""A typo in a script is refused where it is made: what was given, where, and what is expected."""

from __future__ import annotations

import numpy as np
import pytest

import supple as sp
from supple.arguments import checked_arguments, given
from supple.equations import StaticSearch
from supple.errors import ArgumentError, SuppleError

STEEL = sp.Isotropic(2e11, 0.3, 7800.0)
MESH = sp.block(1.0, 0.1, 0.1, 2, 1, 1, sp.CellType.TETRA4)
MODEL = sp.solid_model(MESH, STEEL)
FLEXIBLE = sp.flexible_body("beam", MODEL, [sp.RigidInterface("root", "root")])
HUB = sp.RigidBody("hub", 1.0, np.zeros(3), np.eye(3), {"centre": np.zeros(3)})
Z = (0.0, 0.0, 1.0)
ENDS = {"first": "ground", "second": "hub.centre"}
FRAME, BASIS = sp.MeanAxisFrame(), sp.CraigBampton(n_modes=1)
HINGE = sp.Revolute(**ENDS, axis=Z)
RUN = sp.Run(0.1, 0.05)

TYPOS = {
    "misspelt interface": (
        lambda: sp.System((HUB,), (sp.Revolute(first="ground", second="hub.center", axis=Z),)),
        "body 'hub' has no interface 'center'; did you mean 'centre'",
    ),
    "misspelt body": (
        lambda: sp.System((HUB,), (sp.Revolute(first="ground", second="hubb.centre", axis=Z),)),
        "there is no body 'hubb'; did you mean 'hub'",
    ),
    "body as end": (lambda: sp.Ball(first="ground", second=HUB), "an end is 'BODY.INTERFACE'"),
    "axis as word": (
        lambda: sp.Revolute(**ENDS, axis="z"),
        r"Revolute, axis: expected 3 numbers, got 'z' \(str\)",
    ),
    "words as axis": (
        lambda: sp.Revolute(**ENDS, axis=("0", "0", "1")),
        "Revolute, axis: expected 3 numbers",
    ),
    "joint name": (lambda: sp.Ball(**ENDS, name=3), r"Ball, name: expected a string, got 3 \(int\)"),
    "unreduced body": (lambda: sp.Placed(FLEXIBLE), r"place reduce\(body, frame, basis\), or FullBody"),
    "mesh as body": (
        lambda: sp.Placed(MESH),
        "Placed, body: expected a RigidBody, a ReducedBody or a FullBody",
    ),
    "word as body": (lambda: sp.System(("hub",)), r"Placed, body: .* got 'hub' \(str\)"),
    "class as body": (
        lambda: sp.Placed(sp.RigidBody),
        r"the class RigidBody itself; give an object: RigidBody\(...\)",
    ),
    "place as words": (
        lambda: sp.Placed(HUB, position=("0", "0", "1")),
        "position of body 'hub': expected an array",
    ),
    "one body": (lambda: sp.System(HUB), "System, bodies: expected a list of bodies, also of a single one"),
    "one joint": (lambda: sp.System((HUB,), HINGE), "System, joints: expected a list of joints"),
    "word as joint": (
        lambda: sp.System((HUB,), ("fixed",)),
        "System, joints: expected joints such as Revolute",
    ),
    "joint as load": (
        lambda: sp.System((HUB,), (), (HINGE,)),
        "System, loads: expected loads such as DeadForce",
    ),
    "gravity as number": (lambda: sp.System((HUB,), gravity=-9.81), "gravity must be three finite numbers"),
    "stiffness as word": (
        lambda: sp.SpringDamper(**ENDS, stiffness="1e3", anchor=Z),
        r"SpringDamper, stiffness: expected a number, got '1e3' \(str\)",
    ),
    "stiffness as list": (
        lambda: sp.SpringDamper(**ENDS, stiffness=[1e3], anchor=Z),
        r"SpringDamper, stiffness: expected a number, got \[1000.0\] \(list\)",
    ),
    "nodes as words": (
        lambda: sp.DeadForce(body="beam", at=["tip"], force=Z),
        "DeadForce, at: expected an array",
    ),
    "table as path": (lambda: sp.Table("law.csv", None), "a law: expected numbers, got 'law.csv'"),
    "ramp as word": (lambda: sp.Ramp("1", 2.0), "a law: expected numbers, got '1'"),
    "duration as word": (lambda: sp.Run("1", 0.1), r"Run, duration: expected a number, got '1' \(str\)"),
    "step as number": (
        lambda: sp.Run(1.0, 0.1, step=0.01),
        "Run, step: expected .*FixedStep or .*AdaptiveStep",
    ),
    "method as word": (lambda: sp.Run(1.0, 0.1, method="newmark"), "Run, method: expected .*TimeIntegrator"),
    "method as class": (
        lambda: sp.Run(1.0, 0.1, method=sp.GeneralizedAlpha),
        "the class GeneralizedAlpha itself",
    ),
    "tolerances as number": (
        lambda: sp.Run(1.0, 0.1, tolerances=1e-6),
        "Run, tolerances: expected .*Tolerances",
    ),
    "half an iteration": (lambda: sp.Tolerances(max_iterations=2.5), "expected a whole number, got 2.5"),
    "frame as word": (
        lambda: sp.reduce(FLEXIBLE, "mean-axis", BASIS, loads=sp.NoLoads),
        r"reduce, frame: .*Frame, got 'mean-axis'",
    ),
    "frame as class": (
        lambda: sp.reduce(FLEXIBLE, sp.MeanAxisFrame, BASIS, loads=sp.NoLoads),
        "the class MeanAxisFrame itself",
    ),
    "basis as word": (
        lambda: sp.reduce(FLEXIBLE, FRAME, "rubin", loads=sp.NoLoads),
        "reduce, basis: .*got 'rubin'",
    ),
    "basis as number": (lambda: sp.reduce(FLEXIBLE, FRAME, 10, loads=sp.NoLoads), "reduce, basis: .*got 10"),
    "frame and basis": (
        lambda: sp.reduce(FLEXIBLE, BASIS, FRAME, loads=sp.NoLoads),
        "reduce, frame: .*got a CraigBampton",
    ),
    "model as body": (
        lambda: sp.reduce(MODEL, FRAME, BASIS, loads=sp.NoLoads),
        "reduce, body: .*FlexibleBody, got a FiniteElementModel",
    ),
    "derivatives as number": (
        lambda: sp.reduce(FLEXIBLE, FRAME, BASIS, derivatives=3, loads=sp.NoLoads),
        "reduce, derivatives: ",
    ),
    "damping as number": (
        lambda: sp.reduce(FLEXIBLE, FRAME, BASIS, damping=0.02, loads=sp.NoLoads),
        "reduce, damping: .*got 0.02",
    ),
    "frame of an object": (
        lambda: sp.NodalFixedFrame(sp.RigidInterface("root", "root")),
        "NodalFixedFrame, interface",
    ),
    "full of a word": (lambda: sp.FullBody(FLEXIBLE, "mean-axis"), "FullBody, frame: .*got 'mean-axis'"),
    "modes as word": (lambda: sp.CraigBampton("4"), "expected a whole number, got '4'"),
    "modes as float": (lambda: sp.Rubin(2.5), "expected a whole number, got 2.5"),
    "mass as word": (
        lambda: sp.RigidBody("h", "1", np.zeros(3), np.eye(3)),
        "RigidBody, mass: expected a number",
    ),
    "points as list": (
        lambda: sp.RigidBody("h", 1.0, Z, np.eye(3), [Z]),
        "RigidBody, points: expected a dictionary",
    ),
    "mesh as model": (
        lambda: sp.flexible_body("b", MESH),
        r"flexible_body 'b', model: expected shell_model\(..\)",
    ),
    "interface as word": (
        lambda: sp.flexible_body("b", MODEL, ["root"]),
        r"expected RigidInterface\(name, nodes\)",
    ),
    "one interface": (
        lambda: sp.flexible_body("b", MODEL, sp.RigidInterface("root", "root")),
        "expected a list of interfaces, got a RigidInterface named 'root'",
    ),
    "modulus as word": (
        lambda: sp.Isotropic("2e11", 0.3, 1.0),
        "Isotropic, youngs_modulus: expected a number",
    ),
    "material as word": (
        lambda: sp.HomogeneousSection("steel", 0.01),
        "HomogeneousSection, material: .*Isotropic",
    ),
    "cell type as word": (lambda: sp.block(1.0, 1.0, 1.0, 1, 1, 1, "tetra4"), "expected a CellType"),
    "cells as list": (lambda: sp.Mesh(MESH.nodes, [[0, 1, 2, 3]]), "Mesh, cells: expected a dictionary"),
    "rows of words": (lambda: sp.Mesh([["0", "0", "0"]], {}), "Mesh, nodes: expected an array of numbers"),
    "no path": (lambda: sp.read_mesh(None), "read_mesh, path: expected a string or a path, got None"),
    "no case": (lambda: sp.read_case(3), "read_case, path: expected a string or a path, got 3"),
    "run as number": (lambda: sp.simulate(sp.System((HUB,)), 1.0), "simulate, run: expected .*Run, got 1.0"),
    "run and system": (
        lambda: sp.simulate(RUN, sp.System((HUB,))),
        "simulate, system: expected .*System, got a Run",
    ),
    "one system": (
        lambda: sp.simulate_batch(sp.System((HUB,)), RUN),
        "simulate_batch, cases: expected a list",
    ),
}


@pytest.mark.parametrize("typo", TYPOS)
def test_a_typo_is_named(typo):
    act, message = TYPOS[typo]
    with pytest.raises(SuppleError, match=message):
        act()


def test_the_error_is_of_both_kinds_that_python_has():
    for kind in (ValueError, TypeError, ArgumentError):
        with pytest.raises(kind):
            sp.Run("1", 0.1)


def test_numbers_of_numpy_and_lists_are_numbers():
    run = sp.Run(np.float32(1.0), np.array(0.5), start=np.int64(0))
    assert len(run.times) == 3
    assert sp.CraigBampton(np.int64(2)).n_modes == 2
    assert sp.RigidBody("h", 1, [0, 0, 0], np.eye(3).tolist()).mass == 1
    assert sp.Revolute(**ENDS, axis=[0, 0, 1]).axis == [0, 0, 1]


def test_whole_numbers_may_be_written_as_floats_and_are_counted_with():
    @checked_arguments
    def counted(number: int, other: int | None = None, size: float = 1):
        return range(number), other, size

    assert counted(3.0, size=2) == (range(3), None, 2)
    for kind in (sp.Tolerances, StaticSearch):
        assert range(kind(max_iterations=20.0).max_iterations) == range(20)
        with pytest.raises(ArgumentError, match=r"expected a whole number, got 2\.5"):
            kind(max_iterations=2.5)


def test_values_are_told_in_few_words():
    assert given(np.zeros((10, 3))) == "an array of shape (10, 3) of float64"
    assert given("x" * 1000).endswith("(str)")
    assert len(given(list(range(1000)))) < 80
