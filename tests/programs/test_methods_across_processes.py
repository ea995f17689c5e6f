"""The marches of all methods: a second process neither traces their programs nor compiles anything large."""

import json
import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

EXPLICIT = """
from fixtures.explicit_bars import explicit_bar
from supple.machine import At, Contact, Placed, RigidPlane, System
from supple.mesh import CellType

part = Placed(explicit_bar(CellType.TETRA4), velocity=(0.5, 0, 0))
wall = Contact(At("bar", "tip"), RigidPlane((4.1, 0, 0), (-1, 0, 0)))
system = System([part], contacts=[wall])
"""
INTRINSIC = """
from fixtures.beam_lines import beam_line, straight
from supple.machine import Fixed, Placed, System
from supple.methods.intrinsic import CLAMPED, intrinsic_body

line = beam_line(straight(1.0, 4), EA=1e4, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.05)
clamp = Fixed(first="ground", second="beam.root", name="clamp")
system = System([Placed(intrinsic_body(line, CLAMPED, 6))], [clamp], gravity=(0, 0, -1.0))
"""
FLOATING = """
from supple.body import RigidBody
from supple.machine import Placed, Revolute, System

bob = RigidBody("bob", 2.0, [0, 0, 0], [[0.15, 0, 0], [0, 0.2, 0], [0, 0, 0.25]], {"hinge": [0, 0, 0.8]})
hinge = Revolute(first="ground", second="bob.hinge", axis=(1, 0, 0), name="hinge")
system = System([Placed(bob, position=[0, 0, -0.8])], [hinge], gravity=(0, -3.0, -9.81))
"""
MARCH = """
import json

import jax
import numpy as np
from supple.algebra.jax_settings import keep_compiled_programs
from supple.integrate import Run
from supple.simulation import simulate

keep_compiled_programs()
traced, jit = [], jax.jit

def counted(function=None, **options):
    if function is not None and function.__name__.startswith("kept_"):
        traced.append(function.__name__)
    return jit(function, **options)

jax.jit = counted
solution = simulate(system, Run(0.02, 0.01))
(body,) = solution.bodies.values()
motion = [value for value in vars(body).values() if isinstance(value, np.ndarray) and value.size]
print(json.dumps({"traced": traced, "end": [float(each[-1].sum()) for each in motion]}))
"""


def _run(machine, folder):
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        "JAX_COMPILATION_CACHE_DIR": str(folder),
    }
    shown = subprocess.run(
        [sys.executable, "-c", machine + MARCH], env=environment, capture_output=True, text=True, check=False
    )
    assert shown.returncode == 0, shown.stderr
    return json.loads(shown.stdout.splitlines()[-1])


@pytest.mark.parametrize(
    ("machine", "march"),
    [(EXPLICIT, "kept_march_to"), (INTRINSIC, "kept_march_lines"), (FLOATING, "kept_march")],
    ids=["explicit", "intrinsic", "floating"],
)
def test_a_second_process_traces_no_program(machine, march, tmp_path):
    first, second = (_run(machine, tmp_path) for _ in range(2))
    assert any(name.startswith(march) for name in first["traced"]), first["traced"]
    assert second["traced"] == []
    assert first["end"]
    assert second["end"] == first["end"]
