"""A small machine as a case file in any system of units: a flexible arm on a hub, a pendulum at its tip."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from supple.mesh import Mesh, strip
from supple.units import UnitSystem

TEXT = """\
title = "arm on a hub"
gravity = [0.0, 0.0, {gravity!r}]
units = {{ {units} }}

[[body]]
name = "hub"
rigid = {{ mass = {mass!r}, inertia = [[{inertia!r}, 0, 0], [0, {inertia!r}, 0], [0, 0, {inertia!r}]] }}
[[body.interface]]
name = "axle"
position = [0.0, 0.0, 0.0]
[[body.interface]]
name = "flange"
position = [{radius!r}, 0.0, 0.0]

[[body]]
name = "arm"
mesh = "arm.inp"
frame = {{ kind = "mean-axis" }}
reduction = {{ basis = "craig-bampton", modes = 3, derivatives = {{ kind = "compressed", number = 2 }} }}
position = [{radius!r}, 0.0, 0.0]
[body.shell]
thickness = {thickness!r}
youngs_modulus = {modulus!r}
poissons_ratio = 0.3
density = {density!r}
[body.damping]
kind = "modal"
ratio = 0.02
[[body.interface]]
name = "root"
nodes = "root"
[[body.interface]]
name = "tip"
nodes = "tip"

[[body]]
name = "bob"
position = [{reach!r}, 0.0, 0.0]
[body.rigid]
mass = {light!r}
centre = [0.0, 0.0, {drop!r}]
inertia = [[{small!r}, 0, 0], [0, {small!r}, 0], [0, 0, {small!r}]]
[[body.interface]]
name = "pin"
position = [0.0, 0.0, 0.0]

[[joint]]
name = "shaft"
kind = "prescribed-rotation"
first = "ground"
second = "hub.axle"
axis = [0.0, 1.0, 0.0]
law = {{ kind = "ramp", value = 0.3, duration = {ramp!r} }}
[[joint]]
name = "clamp"
kind = "fixed"
first = "hub.flange"
second = "arm.root"
[[joint]]
name = "pin"
kind = "revolute"
first = "arm.tip"
second = "bob.pin"
axis = [0.0, 1.0, 0.0]

[[load]]
kind = "force"
at = "arm.tip"
vector = [0.0, 0.0, {force!r}]
[[spring]]
kind = "torsion"
first = "arm.tip"
second = "bob.pin"
axis = [0.0, 1.0, 0.0]
stiffness = {torsion!r}
damping = {torsion_damping!r}

[simulation]
duration = {duration!r}
output_step = {output!r}
step = {step!r}

[output]
track = ["arm.tip", "bob.pin"]
colour = "von-mises"
pictures = {pictures}
animation = false
"""


def abaqus(mesh: Mesh, first_node: int = 101, first_element: int = 5001) -> str:
    """A mesh of triangles as Abaqus input; ids begin where they are told to, and have gaps."""
    node = [first_node + 2 * i for i in range(mesh.n_nodes)]
    lines = [
        "*NODE",
        *(f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in zip(node, mesh.nodes.tolist(), strict=True)),
    ]
    (cells,) = mesh.cells.values()
    lines.append("*ELEMENT, TYPE=S3, ELSET=all")
    lines += [
        f"{first_element + 3 * e}, {', '.join(str(node[i]) for i in c)}" for e, c in enumerate(cells.tolist())
    ]
    for name, members in mesh.node_sets.items():
        lines += [f"*NSET, NSET={name}", ", ".join(str(node[i]) for i in members.tolist())]
    return "\n".join(lines) + "\n"


@pytest.fixture
def machine(tmp_path) -> Callable[..., Path]:
    """Writes the machine in some units, given by what the case file says of them; returns the case file."""

    def write(folder: str, units: dict[str, str], *, steps: int = 40, pictures: bool = False) -> Path:
        system = UnitSystem.stated(units)

        def of(si: float, **powers: int) -> float:
            factor = system.in_si(**powers)
            return float(si if factor is None else si / factor)

        length = {"length": 1}
        text = TEXT.format(
            units=", ".join(f'{name} = "{unit}"' for name, unit in units.items()),
            gravity=of(-9.81, length=1, time=-2),
            mass=of(2.0, mass=1),
            light=of(0.05, mass=1),
            inertia=of(0.01, mass=1, length=2),
            small=of(1e-5, mass=1, length=2),
            radius=of(0.1, **length),
            reach=of(1.1, **length),
            drop=of(-0.05, **length),
            thickness=of(0.004, **length),
            modulus=of(7e10, mass=1, length=-1, time=-2),
            density=of(2700.0, mass=1, length=-3),
            force=of(-2.0, mass=1, length=1, time=-2),
            torsion=of(0.1, mass=1, length=2, time=-2),
            torsion_damping=of(1e-3, mass=1, length=2, time=-1),
            ramp=of(0.2, time=1),
            duration=of(0.005 * steps, time=1),
            output=of(0.01, time=1),
            step=of(0.005, time=1),
            pictures=str(pictures).lower(),
        )
        (tmp_path / folder).mkdir()
        size = of(1.0, **length)
        (tmp_path / folder / "arm.inp").write_text(abaqus(strip(size, 0.06 * size, 8, 2)), encoding="utf-8")
        path = tmp_path / folder / "machine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write
