"""The bodies of a case: kind, reduction, and initial position and velocity."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from supple.body import (
    BodyForm,
    BodySource,
    FlexibleBody,
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    RigidBody,
    check_rigid_connections,
    rigid_mass_properties,
    stiff_cells,
)
from supple.cases import (
    condense,
    damping,
    explicit_parts,
    interfaces,
    reductions,
    split,
    stated_lines,
)
from supple.cases.body_kinds import (
    KINDS,
    Abaqus,
    ElasticKind,
    Matrices,
    Nastran,
    Rigid,
    SectionTableFile,
    Shell,
    Solid,
    Superelement,
    is_explicit_table,
    kind_of,
)
from supple.cases.condense import Condense, is_condensed
from supple.cases.damping import Damping, LinearRayleigh, Modal, Rayleigh
from supple.cases.explicit_parts import ExplicitPart, ModalPart
from supple.cases.interfaces import InterfaceTable
from supple.cases.notify import Notify
from supple.cases.reductions import FullOrder, Reduced, Reduction, derivative_choice, quartic_choice
from supple.cases.shared_rules import FileName, usable_names
from supple.cases.split import Split
from supple.cases.stated_lines import stated_line
from supple.cases.table import Key, Made, OneOf, table_of
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.importers.toml import (
    ZERO,
    CheckedTable,
    KeyPath,
    Mistakes,
    Raw,
    Vector,
    names,
    on_each,
    table,
    unknown,
)
from supple.machine import Placed
from supple.methods.explicit import ExplicitShell, ExplicitSubdomain, ModalSubdomain
from supple.methods.intrinsic import IntrinsicBody
from supple.reduction import CondensedQuartic, NoLoads, ReducedBody, reduce
from supple.reduction.eigenvalues.mode_search import search_words
from supple.storage import read_reduced_body

MeanAxis = table_of(MeanAxisFrame, "mean-axis")
NodalFixed = table_of(NodalFixedFrame, "nodal-fixed", interface=Key(str, "interface that carries the frame"))
Frame = Annotated[Made, OneOf(MeanAxis, NodalFixed)]


class Body(CheckedTable):
    """A rigid or elastic body and its initial state."""

    name: str = Field(min_length=1, description="used as NAME.INTERFACE by joints, loads and output")
    mesh: FileName | None = Field(
        None,
        description="mesh file beside the case file: Gmsh .msh, Abaqus/CalculiX .inp or Nastran .bdf; "
        "for matrices also HDF5 .h5",
    )
    cells: str | None = Field(
        None, description="cell set of the mesh that forms this body (shell, solid); default: all cells"
    )
    shell: Shell | None = None
    solid: Solid | None = None
    nastran: Nastran | None = None
    abaqus: Abaqus | None = None
    matrices: Matrices | None = None
    superelement: Superelement | None = None
    rigid: Rigid | None = None
    reduced: FileName | None = Field(
        None, description="file of a reduced body, made by supple reduce, beside the case file"
    )
    section_table: FileName | None = Field(
        None,
        description="file of 6 x 6 stiffness and inertia along a curve, beside the case file: .csv, windIO "
        ".yaml or BeamDyn primary file .dat",
    )
    interface: Annotated[tuple[InterfaceTable, ...], Field(strict=False)] = ()
    frame: Frame | None = None
    reduction: Reduction | None = None
    damping: Damping | None = None
    split: Split | None = None
    condense: Condense | None = None
    modal: ModalPart | None = None
    explicit: ExplicitPart | None = None
    linear: bool = Field(False, description="true omits the nonlinear strains (for comparison)")
    position: Vector = Field(ZERO, description="initial position of the mesh origin, global axes, a length")
    rotation: Vector = Field(ZERO, description="initial orientation as a rotation vector, global axes, rad")
    velocity: Vector | None = Field(
        None,
        description="initial velocity of the mesh origin, global axes; default: from joints and laws",
    )
    centre_velocity: Vector | None = Field(
        None,
        description="instead of velocity: initial velocity of the centre of mass, global axes",
    )
    angular_velocity: Vector | None = Field(
        None,
        description="initial angular velocity, body axes, rad per time; default as for velocity",
    )

    @property
    def kind(self) -> str:
        """Key of the body's kind in `KINDS`."""
        return next(key for key in KINDS if getattr(self, key) is not None)

    @property
    def elastic(self) -> ElasticKind | None:
        """The kind of an elastic body that the case builds; None otherwise.

        None also if `is_line`: such a body exists in intrinsic modes only.
        """
        if self.is_line:
            return None
        if self.section_table is not None:
            return SectionTableFile(file=self.section_table)
        made_of = getattr(self, self.kind)
        return made_of if isinstance(made_of, ElasticKind) else None

    @property
    def is_line(self) -> bool:
        """True for a condensed body from a section table, or from matrices on a load path."""
        return self.condense is not None and (self.section_table is not None or self.matrices is not None)

    @property
    def is_explicit(self) -> bool:
        """True for a body in explicit integration, modal or of finite elements."""
        return self.modal is not None or self.explicit is not None

    @property
    def corrects_itself(self) -> bool:
        """True for an elastic body whose reduction has no fixed size."""
        if self.reduction is None:
            return self.elastic is not None and self.condense is None and not self.is_explicit
        return self.reduction.corrects_itself

    def flexible(self, source: BodySource) -> FlexibleBody:
        """The elastic body, not yet reduced.

        Raises
        ------
        ModelError   a model that fails its check (the message lists all findings); an RBE2 that is not an
                     interface; an interface that cannot be built
        """
        try:
            connections = source.connections()
            if not source.ties_itself:
                taken = {each.connection for each in self.interface}
                taken |= {each.nodes for each in self.interface if each.kind == "rigid"}
                check_rigid_connections(self.name, self.mesh or "", connections, taken)
            body = source.body(
                self.name, [each.build(connections, source.numbers) for each in self.interface]
            )
        except ModelError:
            source.check(0).raise_if_refused(self.name)
            raise
        return body.linearized() if self.linear else body

    def build(
        self,
        flexible: FlexibleBody | None,
        folder: Path,
        notify: Notify,
        elements: FiniteElementModel | None = None,
    ) -> Placed:
        """The body in its initial state; not reduced if its basis is "none" or its reduction corrects itself.

        flexible : from `flexible`; None for a body that is not elastic, or is read from a file
        folder : folder of the case, which contains the files of reduced bodies, section tables and matrices
        notify : called at each long step
        elements : finite elements of a body with `explicit`; None for all others
        """
        if self.is_explicit:
            return self.placed(self._part(flexible, elements, notify))
        return self.placed(self._form(flexible, folder, notify))

    def placed(self, form: BodyForm) -> Placed:
        """The body in its initial state, from a form that is built already."""
        given = {key: getattr(self, key) for key in _START}
        start: dict[str, Any] = {key: np.array(value) for key, value in given.items() if value is not None}
        placed = Placed(form, **start)
        return placed if self.centre_velocity is None else placed.with_centre_velocity(self.centre_velocity)

    def line(self, folder: Path, notify: Notify) -> IntrinsicBody:
        """The body of `is_line`, in intrinsic modes; arguments as for `build`."""
        notify(f"reading body '{self.name}', condensed already")
        made = stated_line(self, folder, self._damping_of_modes())
        notify(f"checked body '{self.name}': {made.line.n} stations, mass {made.mass:.5g}")
        return made

    def _damping_of_modes(self) -> RayleighDamping | ModalDamping | None:
        # A rule of the case file allows only these kinds of damping here; they need no body and frame.
        return self.damping.build() if isinstance(self.damping, Rayleigh | Modal) else None

    def _part(
        self, flexible: FlexibleBody | None, elements: FiniteElementModel | None, notify: Notify
    ) -> ModalSubdomain | ExplicitSubdomain | ExplicitShell:
        """The body in explicit integration."""
        damping = self.damping.build() if isinstance(self.damping, LinearRayleigh) else None
        if self.modal is not None:
            assert flexible is not None
            notify(f"reducing body '{self.name}' ({flexible.n} freedoms)")
            return self.modal.build(flexible, damping)
        assert self.explicit is not None
        assert elements is not None
        return self.explicit.build(self.name, elements, damping)

    def _form(
        self, flexible: FlexibleBody | None, folder: Path, notify: Notify
    ) -> RigidBody | ReducedBody | FullBody | IntrinsicBody:
        if self.reduced is not None:
            return replace(read_reduced_body(folder / self.reduced), name=self.name)
        made_of = getattr(self, self.kind)
        if isinstance(made_of, Rigid):
            places = {i.name: np.array(i.position) for i in self.interface if i.position is not None}
            return made_of.body(self.name, places)
        if self.condense is not None:
            if self.is_line:
                return self.line(folder, notify)
            assert flexible is not None
            notify(f"condensing body '{self.name}' ({flexible.n} freedoms)")
            return self.condense.build(flexible, self._damping_of_modes())
        assert flexible is not None
        assert self.frame is not None  # a rule of the case file
        frame = self.frame.build()
        damped = self.damping.build(flexible, frame) if self.damping else None
        if self.reduction is None or self.reduction.corrects_itself or isinstance(self.reduction, FullOrder):
            return FullBody(flexible, frame, damped)
        step = f"reducing body '{self.name}' ({flexible.n} freedoms)"
        notify(step)
        assert isinstance(self.reduction, Reduced)
        body = reduce(
            flexible,
            frame,
            self.reduction.recipe(lambda detail: notify(step, detail)),
            loads=NoLoads,  # the recipe contains them, if selected
            derivatives=derivative_choice(self.reduction.derivatives),
            damping=damped,
            quartic=quartic_choice(self.reduction.condensed, CondensedQuartic()),
        )
        proven = body.report.certificate
        if proven is not None:  # the last trial of the search may not be the chosen one
            notify(step, search_words(proven.n_fixed_interface_modes, proven.largest_error))
        return body


_START = ("position", "rotation", "velocity", "angular_velocity")
_MADE_OF_CELLS = (Shell, Solid)
_ELASTIC_ONLY = ("frame", "reduction", "damping", "split", "linear", "condense")


def checked_line(body: FlexibleBody) -> str:
    """One line on a body that has passed the model check, with its mass; the check is not repeated here."""
    found = rigid_mass_properties(body.nodal_mass, body.nodes, body.dofs_per_node)
    stiff = stiff_cells(body.model) if body.model is not None else {}
    cells = "".join(f"; {number} {name}: too stiff in bending" for name, number in stiff.items())
    return f"checked body '{body.name}': free, no mechanism, symmetric, mass {found.mass:.5g}{cells}"


def _bodies_are_there(raw: Raw) -> Mistakes:
    if raw.get("body") == []:
        yield ("body",), "a case needs at least one [[body]]"


def _is_of_one_kind(path: KeyPath, body: Raw) -> Mistakes:
    given = [key for key in KINDS if key in body]
    if len(given) != 1:
        seen = f"this one has {' and '.join(given)}" if given else "this one has none"
        yield path, f"a body needs exactly one of {', '.join(KINDS)}; {seen}"
        return
    (key,) = given
    kind = KINDS[key]
    if kind.mesh_suffixes and "mesh" not in body:
        yield path, f'a {key} body needs a mesh; add mesh = "FILE{kind.mesh_suffixes[0]}"'
    if not kind.mesh_suffixes and "mesh" in body:
        yield (*path, "mesh"), f"a {key} body takes no mesh; remove the key"
    if kind.is_elastic and "frame" not in body and not is_condensed(body) and not is_explicit_table(body):
        yield path, f'a {key} body needs frame; for example frame = {{kind = "mean-axis"}}'
    if "cells" in body and kind not in _MADE_OF_CELLS:
        yield (*path, "cells"), f"cells is for shell and solid bodies, not for a {key} body; remove the key"
    if not kind.is_elastic:
        for needless in (each for each in _ELASTIC_ONLY if each in body):
            yield (*path, needless), f"a {key} body takes no {needless}; remove the key"


def _has_one_velocity(path: KeyPath, body: Raw) -> Mistakes:
    if "centre_velocity" not in body:
        return
    if "velocity" in body:
        message = "give the velocity of the mesh origin or that of the centre of mass, not both"
        yield (*path, "centre_velocity"), message
    if "split" in body:
        message = "each part of a split body has its own centre of mass; give velocity (of the mesh origin)"
        yield (*path, "centre_velocity"), message


def _mesh_can_be_read(path: KeyPath, body: Raw) -> Mistakes:
    kind, mesh = kind_of(body), body.get("mesh")
    allowed = (kind.mesh_suffixes if kind is not None else ()) or Shell.mesh_suffixes
    if isinstance(mesh, str) and Path(mesh).suffix.lower() not in allowed:
        yield (*path, "mesh"), f"{mesh!r} is not a readable mesh; give a file {' or '.join(allowed)}"


def _interfaces_have_names(path: KeyPath, body: Raw) -> Mistakes:
    yield from usable_names(body, "interface", path)
    for key, inner in (("frame", "interface"), ("damping", "held")):
        wanted, known = table(body, key).get(inner), names(body, "interface")
        if isinstance(wanted, str) and wanted not in known:
            yield (*path, key, inner), unknown("interface", wanted, known)


RULES = (
    _bodies_are_there,
    lambda raw: usable_names(raw, "body"),
    stated_lines.tables_are_in_units_of_the_case,
    on_each(
        "body",
        _is_of_one_kind,
        _has_one_velocity,
        _mesh_can_be_read,
        _interfaces_have_names,
        *interfaces.RULES_OF_BODY,
        *reductions.RULES_OF_BODY,
        *damping.RULES_OF_BODY,
        *split.RULES_OF_BODY,
        *condense.RULES_OF_BODY,
        *stated_lines.RULES_OF_BODY,
        *explicit_parts.RULES_OF_BODY,
    ),
)
