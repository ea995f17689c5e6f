"""The tables of a case file: every key, its type, its range and its unit.

What one key demands of another (and of the files around) is in `case_rules`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

# Strict numbers and strings (no "0.02" for 0.02), but a TOML array may fill a tuple.
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Matrix = Annotated[tuple[Vector, Vector, Vector], Field(strict=False)]
NodeIndices = Annotated[tuple[int, ...], Field(strict=False)]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]

ZERO: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Table(BaseModel):
    """A table of the case file: unknown keys are mistakes, values cannot change, numbers are finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Shell(Table):
    """Homogeneous flat-shell triangles on every cell of the mesh."""

    thickness: Positive = Field(description="wall thickness, m")
    youngs_modulus: Positive = Field(description="Young's modulus, Pa")
    poissons_ratio: float = Field(gt=-1.0, lt=0.5, description="Poisson's ratio")
    density: Positive = Field(description="mass per volume, kg/m3")
    kinematics: Literal["green-lagrange", "von-karman"] = Field(
        "green-lagrange",
        description="membrane strain; von-karman only for flat structures bending out of their plane",
    )


class Solid(Table):
    """Green-Lagrange solid elements (tetrahedra, hexahedra) on every cell of the mesh."""

    youngs_modulus: Positive = Field(description="Young's modulus, Pa")
    poissons_ratio: float = Field(gt=-1.0, lt=0.5, description="Poisson's ratio")
    density: Positive = Field(description="mass per volume, kg/m3")


class Nastran(Table):
    """The elements, materials and walls of a Nastran bulk data file."""

    kinematics: Literal["green-lagrange", "von-karman"] = Field(
        "green-lagrange",
        description="membrane strain of shells; von-karman only for flat ones bending out of their plane",
    )


class Matrices(Table):
    """A linear body from matrices exported by another program, with the nodes of its mesh file."""

    stiffness: str = Field(
        description="DMIG .pch, OUTPUT4 .op4, HDF5 .h5, Abaqus .mtx or CalculiX .sti, beside the case file"
    )
    mass: str = Field(description="likewise, or CalculiX .mas; may be the same file")
    stiffness_name: str | None = Field(
        None, description="matrix to take from a DMIG or OUTPUT4 file; the one with K.. if left out"
    )
    mass_name: str | None = Field(None, description="likewise; the one with M.. if left out")
    rigid_tolerance: Positive | None = Field(
        None, description="largest relative force against rigid motion; from the printed digits if left out"
    )


class Superelement(Table):
    """A linear body from matrices made elsewhere."""

    stiffness: str = Field(description="Matrix Market file of the stiffness matrix, beside the case file")
    mass: str = Field(description="Matrix Market file of the mass matrix, beside the case file")
    nodes: str = Field(description="Matrix Market file of the node positions, an array of 3 columns, m")
    dofs_per_node: Literal[3, 6] = Field(
        description="freedoms per node: 3 (translations) or 6 (and rotations)"
    )


class Rigid(Table):
    """A rigid body."""

    mass: Positive = Field(description="kg")
    centre: Vector = Field(ZERO, description="centre of mass in body axes, m")
    inertia: Matrix = Field(description="inertia tensor about the centre of mass in body axes, 3 rows, kg m2")


class Interface(Table):
    """A named place where joints, loads and springs take hold of a body."""

    name: str = Field(min_length=1, description="used as BODY.NAME by joints, loads and output")
    nodes: str | None = Field(None, description="a node set of the mesh")
    node_indices: NodeIndices | None = Field(None, description="node numbers from 0, instead of a node set")
    connection: str | None = Field(
        None, description="rbe2_ID or rbe3_ID of a Nastran mesh, instead of nodes, kind and position"
    )
    kind: Literal["rigid", "averaging"] = Field("rigid", description="rigid (RBE2) or averaging (RBE3)")
    position: Vector | None = Field(
        None, description="body axes, m; elastic bodies: the set's centroid if left out"
    )


class MeanAxis(Table):
    """Frame that follows the mean motion of the body."""

    kind: Literal["mean-axis"]


class NodalFixed(Table):
    """Frame fixed to one interface."""

    kind: Literal["nodal-fixed"]
    interface: str = Field(description="name of the interface the frame moves with")


class AllPairsCompressed(Table):
    """Modal derivatives of all pairs, compressed to the leading directions."""

    kind: Literal["compressed"]
    number: int = Field(ge=1, description="directions kept")


class Picked(Table):
    """The modal derivatives of the heaviest pairs."""

    kind: Literal["picked"]
    number: int = Field(ge=1, description="derivatives kept")


class NoDerivatives(Table):
    """A basis without modal derivatives: small deformation only."""

    kind: Literal["none"]


Derivatives = Annotated[AllPairsCompressed | Picked | NoDerivatives, Field(discriminator="kind")]


class Accuracy(Table):
    """The error down to which a reduction corrects itself; 1e-3 relative if neither is given."""

    relative: Positive | None = Field(
        None,
        description="largest RMS error of the nodes over their largest displacement from the first interface",
    )
    absolute: Positive | None = Field(None, description="largest RMS error of the nodes, m")
    instants: int = Field(50, ge=1, description="output times at which a run's residual is evaluated")
    directions: int = Field(3, ge=1, description="columns added a round")
    largest_size: int = Field(60, ge=1, description="coordinates")
    max_rounds: int = Field(8, ge=1, description="enrichments before giving up")


class Rubin(Table):
    """Free-interface modes and attachment modes."""

    basis: Literal["rubin"]
    modes: int | None = Field(None, ge=1, description="vibration modes, besides the attachment modes")
    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None


class CraigBampton(Table):
    """Fixed-interface modes and constraint modes."""

    basis: Literal["craig-bampton"]
    modes: int | None = Field(None, ge=0, description="fixed-interface modes, besides the constraint modes")
    select: Literal["lowest-frequency", "effective-interface-mass", "coupling-moment"] = Field(
        "lowest-frequency", description="which modes are kept: the lowest, or those the interfaces feel most"
    )
    candidates: int | None = Field(
        None, ge=1, description="lowest modes to select among; five times as many as are kept if left out"
    )
    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None


class CraigBamptonResidual(Table):
    """Fixed-interface modes, constraint modes, and the static answer of the modes left out."""

    basis: Literal["craig-bampton-residual"]
    modes: int | None = Field(
        None, ge=0, description="fixed-interface modes, besides the constraint and residual modes"
    )
    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None


class Herting(Table):
    """Constraint modes, inertia relief modes and free-interface modes."""

    basis: Literal["herting"]
    modes: int | None = Field(
        None, ge=1, description="free-interface modes, besides the constraint and inertia relief modes"
    )
    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None


class NormalModes(Table):
    """Vibration modes only."""

    basis: Literal["normal-modes"]
    modes: int | None = Field(None, ge=1, description="vibration modes")
    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None


class Guyan(Table):
    """Static shapes of the interfaces only."""

    basis: Literal["guyan"]
    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None


class ErrorControlled(Table):
    """The lowest vibrations of the free body, each eigenvalue proven to be within a tolerance."""

    basis: Literal["error-controlled"]
    # The lower end is what round-off leaves, as in supple.reduction.
    tolerance: float = Field(
        ge=1e-7, lt=1.0, description="largest relative error of the eigenvalues, such as 1e-3 for 0.1 %"
    )
    modes: int = Field(ge=1, description="elastic eigenvalues, the lowest, that are within the tolerance")
    attachment_modes: bool = Field(
        True, description="false leaves out the static answers to forces at the interfaces"
    )
    derivatives: Derivatives | None = None


class FullOrder(Table):
    """No reduction: every freedom of the mesh is simulated."""

    basis: Literal["none"]


CountedOrder = Rubin | CraigBampton | CraigBamptonResidual | Herting | NormalModes
CorrectableOrder = CountedOrder | Guyan
ReducedOrder = CorrectableOrder | ErrorControlled
Reduction = Annotated[ReducedOrder | FullOrder, Field(discriminator="basis")]


class RayleighRatio(Table):
    """Rayleigh damping with the same ratio on two modes of the body in its frame."""

    kind: Literal["rayleigh-ratio"]
    ratio: NonNegative = Field(description="damping ratio, 0.02 for 2 %")
    modes: Annotated[tuple[int, int], Field(strict=False)] = Field((1, 2), description="mode numbers from 1")
    held: str | None = Field(
        None, description="interface held while these modes vibrate; none: free in the frame"
    )


class Rayleigh(Table):
    """Rayleigh damping alpha M + beta K."""

    kind: Literal["rayleigh"]
    alpha: NonNegative = Field(description="1/s")
    beta: NonNegative = Field(description="s")


class Modal(Table):
    """The same damping ratio on every mode of the reduced body."""

    kind: Literal["modal"]
    ratio: NonNegative = Field(description="damping ratio, 0.02 for 2 %")


Damping = Annotated[RayleighRatio | Rayleigh | Modal, Field(discriminator="kind")]


class Body(Table):
    """A rigid or elastic body and where it starts."""

    name: str = Field(min_length=1, description="used as NAME.INTERFACE by joints, loads and output")
    mesh: str | None = Field(
        None,
        description="mesh file beside the case file: Gmsh .msh, Abaqus/CalculiX .inp or Nastran .bdf; "
        "for matrices also HDF5 .h5",
    )
    shell: Shell | None = None
    solid: Solid | None = None
    nastran: Nastran | None = None
    matrices: Matrices | None = None
    superelement: Superelement | None = None
    rigid: Rigid | None = None
    reduced: str | None = Field(
        None, description="file of a reduced body, made by supple reduce, beside the case file"
    )
    interface: Annotated[tuple[Interface, ...], Field(strict=False)] = ()
    frame: Annotated[MeanAxis | NodalFixed, Field(discriminator="kind")] | None = None
    reduction: Reduction | None = None
    damping: Damping | None = None
    linear: bool = Field(False, description="true leaves the nonlinear strains out (for comparison)")
    position: Vector = Field(ZERO, description="start of the mesh origin, global axes, m")
    rotation: Vector = Field(ZERO, description="start orientation as a rotation vector, global axes, rad")
    velocity: Vector = Field(ZERO, description="start velocity of the mesh origin, global axes, m/s")
    angular_velocity: Vector = Field(ZERO, description="start angular velocity, body axes, rad/s")


class Constant(Table):
    """value"""

    kind: Literal["constant"]
    value: float


class Ramp(Table):
    """From 0 to value in duration with a smooth start and end, then constant."""

    kind: Literal["ramp"]
    value: float
    duration: Positive = Field(description="s")


class Sine(Table):
    """amplitude sin(2 pi frequency_hz t)"""

    kind: Literal["sine"]
    amplitude: float
    frequency_hz: Positive = Field(description="Hz")


class SpinUp(Table):
    """An angle (or path) whose rate grows smoothly from 0 to speed in duration, then stays."""

    kind: Literal["spin-up"]
    speed: float = Field(description="rate after the spin-up, rad/s or m/s")
    duration: Positive = Field(description="s")


class TableLaw(Table):
    """Values from a file, joined by a curve that is smooth enough for prescribed motion (cubic spline)."""

    kind: Literal["table"]
    file: str = Field(description="CSV file of time,value rows beside the case file")


Law = Annotated[Constant | Ramp | Sine | SpinUp | TableLaw, Field(discriminator="kind")]


JointKind = Literal[
    "fixed",
    "ball",
    "revolute",
    "universal",
    "cylindrical",
    "prismatic",
    "prescribed-rotation",
    "prescribed-translation",
]


class Joint(Table):
    """A connection of two interfaces, or of one with the ground."""

    kind: JointKind
    name: str | None = Field(None, description="label in results; made from kind and ends if left out")
    first: str = Field(description="ground or BODY.INTERFACE")
    second: str = Field(description="BODY.INTERFACE")
    axis: Vector | None = Field(
        None, description="direction at the start, global axes; its length does not matter"
    )
    second_axis: Vector | None = Field(None, description="universal: the other cross-pin axis, global axes")
    law: Law | None = Field(None, description="prescribed joints: angle in rad, or path in m, against time")


class Load(Table):
    """A force or torque in time."""

    kind: Literal["force", "torque"]
    at: str = Field(description="BODY.INTERFACE; or BODY.NODE_SET, whose nodes share a force evenly")
    vector: Vector = Field(description="N or N m, along global axes (at the start, if it follows)")
    follower: bool = Field(False, description="true turns the load with its interface")
    law: Law = Field(
        default=Constant(kind="constant", value=1.0), description="factor on vector against time"
    )


class StraightSpring(Table):
    """A spring and damper along the line between two interfaces that stay apart."""

    kind: Literal["straight"]
    first: str = Field(description="BODY.INTERFACE")
    second: str = Field(description="BODY.INTERFACE")
    stiffness: NonNegative = Field(description="N/m")
    damping: NonNegative = Field(0.0, description="N s/m")
    free_length: NonNegative | None = Field(None, description="m; the distance at the start if left out")


class TorsionSpring(Table):
    """A spring and damper about an axis, between two interfaces or one and the ground."""

    kind: Literal["torsion"]
    first: str = Field(description="ground or BODY.INTERFACE")
    second: str = Field(description="BODY.INTERFACE")
    axis: Vector = Field(description="direction at the start, global axes; its length does not matter")
    stiffness: NonNegative = Field(description="N m/rad")
    damping: NonNegative = Field(0.0, description="N m s/rad")
    free_angle: float = Field(0.0, description="rad")


Spring = Annotated[StraightSpring | TorsionSpring, Field(discriminator="kind")]


class Adaptive(Table):
    """Steps chosen from the local error."""

    first: Positive = Field(description="first step, s")
    largest: Positive = Field(description="largest step, s")
    tolerance: Positive = Field(
        1e-6, description="local error allowed per step, relative to the system's size"
    )


class Simulation(Table):
    """Span of time and method."""

    duration: Positive = Field(description="s")
    output_step: Positive = Field(description="time between stored states, s")
    step: Positive | None = Field(None, description="fixed time step, s")
    adaptive: Adaptive | None = None
    rho_inf: float = Field(
        0.8, ge=0.0, le=1.0, description="spectral radius at infinity of generalized-alpha"
    )


class Output(Table):
    """What is drawn besides the result file."""

    track: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="BODY.INTERFACE or BODY.NODE_SET whose motion is printed and drawn"
    )
    pictures: bool = Field(True, description="draw mesh, modes, motion and deformed bodies (PNG)")
    animation: bool = Field(True, description="draw the motion (GIF)")
    colour: Literal["deflection", "von-mises"] = Field(
        "deflection",
        description="what colours the film; von-mises also draws contours where the stress is largest",
    )


class Case(Table):
    """A whole case file."""

    title: str = Field(description="one line for tables and pictures")
    gravity: Vector = Field(ZERO, description="global axes, m/s2")
    units: dict[str, str] = Field(
        default_factory=dict, description="a note only: the numbers must be one consistent set"
    )
    body: Annotated[tuple[Body, ...], Field(strict=False)]
    joint: Annotated[tuple[Joint, ...], Field(strict=False)] = ()
    load: Annotated[tuple[Load, ...], Field(strict=False)] = ()
    spring: Annotated[tuple[Spring, ...], Field(strict=False)] = ()
    simulation: Simulation
    output: Output = Field(default_factory=lambda: Output.model_validate({}))
