"""Explicit time integration: constants as arrays, methods as static objects, and the state."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass, register_static

from supple.equations.configuration import ControlState
from supple.equations.machine_model import Model
from supple.equations.nodal_load import PreparedLoad
from supple.machine.laws.time_law import TimeLaw
from supple.machine.obstacles import Obstacle
from supple.methods.explicit.elements import BlockState, ShellBlock, SolidBlock
from supple.methods.explicit.frame_chart import FrameChart
from supple.methods.explicit.frame_model import FrameModel, FrameState
from supple.methods.explicit.march.touching_surface import TouchingSurface
from supple.methods.explicit.march.turning_nodes import Spins, TriadState
from supple.methods.explicit.method import Explicit
from supple.methods.explicit.modal_tie import ModalTie

__all__ = ["Energies"]


class ObstacleState(NamedTuple):
    """Displacement of an obstacle, (3,), and its velocity over the last step."""

    offset: Array
    velocity: Array


@register_dataclass
@dataclass(frozen=True, eq=False)
class NodesTouching:
    """Nodes in contact with an obstacle.

    nodes : (n,) numbers of explicit nodes, or of nodes of a modal part
    stiffness : (n,) N/m
    weights, shapes : (n, 4), (n, 3, k) of a modal part's points; empty for explicit nodes
    number : number of the obstacle
    """

    nodes: Array
    stiffness: Array
    weights: Array
    shapes: Array
    number: int = field(metadata={"static": True})
    obstacle: Obstacle = field(metadata={"static": True})

    def push(self, obstacles: tuple[ObstacleState, ...], x: Array) -> Array:
        """Forces (3, n) of the obstacle on points x (3, n)."""
        gap, normal = self.obstacle.gap(x - obstacles[self.number].offset[:, None])
        return self.stiffness * jnp.maximum(-gap, 0.0) * normal


class FrameArrays(NamedTuple):
    """A modal sub-domain in the model.

    model : FrameModel      with the mass of the nodes tied to it
    nodes : (n,)            explicit nodes tied to it, at weights (n, 4) and shapes (n, 3, k)
    touching : tuple of NodesTouching       contacts of its own points
    chart : the floating frame of its points
    step_limit : step limit at rest, s;   spin_bound : see `ModalFrame.spin_bound`
    """

    model: FrameModel
    nodes: Array
    weights: Array
    shapes: Array
    touching: tuple[NodesTouching, ...]
    chart: FrameChart
    step_limit: Array
    spin_bound: Array | None


class MarchModel(NamedTuple):
    """Arrays of the model.

    blocks : blocks of explicit elements
    mass, alpha : (N,) of the nodes, kg and 1/s;   movable : (3, N) 1, or 0 for fixed ones
    ties : ties between frames
    touching, surfaces : contacts with obstacles, and between parts
    contact_rate : largest stiffness over mass of a node in contact, 1/s^2
    base_accelerations : laws of base accelerations, (3,) m/s^2
    machine : the frames as floating bodies with their joints and forces; None without frames
    loaded : nodes, number of nodes that share the force, and law of each force on explicit nodes
    pressed : nodes and `PreparedLoad` of each pressure on faces of explicit elements
    driven : (m,)   1 for equations of joints with laws, else 0
    """

    blocks: tuple[SolidBlock | ShellBlock, ...]
    mass: Array
    alpha: Array
    movable: Array
    frames: tuple[FrameArrays, ...]
    ties: tuple[ModalTie, ...]
    touching: tuple[NodesTouching, ...]
    surfaces: tuple[TouchingSurface, ...]
    loaded: tuple[tuple[Array, float, TimeLaw], ...]
    pressed: tuple[tuple[Array, PreparedLoad], ...]
    obstacle_mass: Array
    gravity: Array
    contact_rate: Array
    spins: Spins
    base_accelerations: tuple[TimeLaw, ...]
    machine: Model | None
    driven: Array


@register_static
@dataclass(frozen=True)
class Methods:
    """Static arguments of the compiled time integration.

    tied : numbers of the two frames of each tie
    joined : numbers of the frames with ties or joints, ascending
    stores : for each group of force elements on frames, whether it stores energy
    explicit : Explicit     options of the run
    """

    tied: tuple[tuple[int, int], ...]
    joined: tuple[int, ...]
    stores: tuple[bool, ...]
    explicit: Explicit


class Energies(NamedTuple):
    """Terms of the energy balance, J; kinetic at the middle of the last step.

    kinetic + internal + plastic + hourglass + contact + damping + interface - external   is constant

    internal : work of stresses that is neither plastic nor viscous, and energy of springs
    hourglass : work of the hourglass control
    contact : energy stored in penalties; interface : energy lost between parts with different steps, and by
        frames that rotate by a finite angle in a step
    external : work of loads, gravity, driven obstacles and joints, and of force elements without stored
        energy
    """

    kinetic: Array
    internal: Array
    plastic: Array
    hourglass: Array
    contact: Array
    damping: Array
    interface: Array
    external: Array


class MarchState(NamedTuple):
    """Complete state at t_n.

    before, frame_before : the last step of the explicit nodes and of the frames, s; zero at the start
    x, v : (3, N);   forces : (4, 3, N) internal, hourglass, contact, external, at t_n
    blocks : state of each block
    smallest : smallest det F of remaining elements since the start
    obstacle_forces : (o, 3) forces of explicit nodes on obstacles at t_n
    initial : energy at the start, J;   largest : energy of the run, the largest at an output time so far, J
    ratio_bound : largest number of element steps in one frame step, limited by the interface loss
    control : state of the controllers; None without controllers
    ratio_wait : output times before a larger ratio is tried;   ratio_patience : wait after a repetition
    """

    time: Array
    before: Array
    frame_before: Array
    x: Array
    v: Array
    forces: Array
    blocks: tuple[BlockState, ...]
    frames: tuple[FrameState, ...]
    obstacles: tuple[ObstacleState, ...]
    turning: TriadState
    obstacle_forces: Array
    energies: Energies
    initial: Array
    largest: Array
    ratio_bound: Array
    ratio_wait: Array
    ratio_patience: Array
    smallest: Array
    steps: Array
    control: ControlState | None
