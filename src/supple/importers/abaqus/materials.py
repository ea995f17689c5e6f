"""Materials of Abaqus and CalculiX: elasticity and density, at the first temperature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.deck import AnisotropicMaterial, IsotropicMaterial
from supple.importers.keyword_file import KeywordBlock, number_rows
from supple.importers.laminate import orthotropic_stiffness

DeckMaterial = IsotropicMaterial | AnisotropicMaterial

_INELASTIC = (
    "PLASTIC",
    "CREEP",
    "CYCLICHARDENING",
    "DRUCKERPRAGER",
    "CONCRETE",
    "VISCOELASTIC",
    "DAMAGEINITIATION",
)
# Index of Abaqus' components 11 22 33 12 13 23 in xx yy zz yz xz xy.
_OURS = np.array([0, 1, 2, 5, 4, 3])


@dataclass
class _Material:
    """Data of one *MATERIAL under construction."""

    name: str
    elastic: KeywordBlock | None = None
    density: float = 0.0


def read_materials(model: AbaqusModel) -> dict[str, DeckMaterial]:
    """Materials by name in upper case; materials without supported elasticity are omitted.

    Raises
    ------
    ImportFormatError   words instead of numbers; fewer constants than a kind of material has
    """
    found: list[_Material] = []
    for placed in model.blocks:
        block = placed.block
        if placed.step:
            continue
        if block.key == "MATERIAL":
            found.append(_Material(block.options.get("NAME", "")))
        elif block.key in _ELASTIC and found:
            found[-1].elastic = block
        elif block.key == "DENSITY" and found:
            rows = number_rows(model.file, block)
            found[-1].density = rows[0][0] if rows else 0.0
        elif block.key in _INELASTIC and found:
            model.report.note(f"*{block.name} of material '{found[-1].name}' is ignored: bodies are elastic")
            continue
        else:
            continue
        model.report.read[block.name] += 1
    materials: dict[str, DeckMaterial] = {}
    for each in found:
        made = None if each.elastic is None else _ELASTIC[each.elastic.key](model, each.elastic, each)
        if made is not None:
            materials[each.name.upper()] = made
    return materials


def _elastic(model: AbaqusModel, block: KeywordBlock, material: _Material) -> DeckMaterial | None:
    kind = block.options.get("TYPE", "ISOTROPIC").upper()
    values = [value for row in number_rows(model.file, block) for value in row]
    n = next((n for word, n in _CONSTANTS.items() if kind.startswith(word)), None)
    if n is None:
        model.report.leave_out(
            f"*ELASTIC, TYPE={kind}", block.line, f"material '{material.name}' is of an unsupported kind"
        )
        return None
    if kind.startswith("LAM") and len(values) == 5:
        values.append(values[-1])
    if len(values) < n:
        raise model.file.error(
            block.line, f"*ELASTIC, TYPE={kind} has {n} constants, not {len(values)}; is the file cut short?"
        )
    # Each further row has the constants at another temperature, then this temperature.
    if len(block.data) > -(-n // 8):
        model.report.note(f"material '{material.name}' depends on temperature; its first row is used")
    v = values[:n]
    if kind.startswith("ISO"):
        return _isotropic(model, block, material, *v)
    stiffness = np.zeros((6, 6))
    if kind.startswith("LAM"):
        # Plane stress does not depend on the moduli through the thickness.
        E1, E2, nu12, G12, G13, G23 = v
        v = [E1, E2, E2, nu12, 0.0, 0.0, G12, G13, G23]
    if kind.startswith(("LAM", "ENG")):
        if all(value > 0 for value in (*v[:3], *v[6:])):
            stiffness = orthotropic_stiffness(*v)
    else:
        rows, columns = _ORTHOTROPIC if kind.startswith("ORTHO") else _ANISOTROPIC
        stiffness[_OURS[rows], _OURS[columns]] = v
        stiffness[_OURS[columns], _OURS[rows]] = v
    if not (np.isfinite(stiffness).all() and np.linalg.eigvalsh(stiffness)[0] > 0):
        return _without_stiffness(model, block, material)
    return AnisotropicMaterial(stiffness, material.density)


def _isotropic(
    model: AbaqusModel, block: KeywordBlock, material: _Material, E: float, nu: float
) -> DeckMaterial | None:
    if not (E > 0 and -1 < nu < 0.5):
        return _without_stiffness(model, block, material)
    return IsotropicMaterial(E, nu, material.density)


def _without_stiffness(model: AbaqusModel, block: KeywordBlock, material: _Material) -> None:
    model.report.leave_out_block(block, f"material '{material.name}' has no positive stiffness")


def _deformation_plasticity(
    model: AbaqusModel, block: KeywordBlock, material: _Material
) -> DeckMaterial | None:
    rows = number_rows(model.file, block)
    if not rows or len(rows[0]) < 2:
        raise model.file.error(
            block.line, "*DEFORMATION PLASTICITY begins with E, nu; is the file cut short?"
        )
    return _isotropic(model, block, material, *rows[0][:2])


def _hyperelastic(model: AbaqusModel, block: KeywordBlock, material: _Material) -> DeckMaterial | None:
    """Isotropic with the moduli at zero strain:  mu = 2 (C10 + C01),  K = 2 / D1, or 20 mu if D1 = 0."""
    rows = number_rows(model.file, block)
    options = block.options.keys()
    named = "NEOHOOKE" in options or "YEOH" in options or "MOONEY-RIVLIN" in options
    if not rows or not named or "TESTDATAINPUT" in options:
        model.report.leave_out_block(block, f"material '{material.name}' is of an unsupported kind")
        return None
    values = [*rows[0], *8 * [0.0]]
    if "NEOHOOKE" in options:
        mu, d1 = 2 * values[0], values[1]
    elif "YEOH" in options:
        mu, d1 = 2 * values[0], values[3]
    else:
        mu, d1 = 2 * (values[0] + values[1]), values[2]
    if not mu > 0:
        return _without_stiffness(model, block, material)
    bulk = 2 / d1 if d1 > 0 else 20 * mu  # incompressible materials as in CalculiX
    model.report.note(f"material '{material.name}' is hyperelastic: its moduli at zero strain are used")
    E, nu = 9 * bulk * mu / (3 * bulk + mu), (3 * bulk - 2 * mu) / (2 * (3 * bulk + mu))
    return _isotropic(model, block, material, E, nu)


def _user(model: AbaqusModel, block: KeywordBlock, material: _Material) -> DeckMaterial | None:
    rows = number_rows(model.file, block)
    # CalculiX ships this law as an example.
    if material.name.upper().startswith("LIN_ISO_EL") and rows and len(rows[0]) > 1:
        return _isotropic(model, block, material, *rows[0][:2])
    model.report.leave_out_block(block, f"the law of material '{material.name}' is user code")
    return None


_ELASTIC = {
    "ELASTIC": _elastic,
    "DEFORMATIONPLASTICITY": _deformation_plasticity,
    "HYPERELASTIC": _hyperelastic,
    "HYPERFOAM": _user,
    "USERMATERIAL": _user,
}
_CONSTANTS = {"ISO": 2, "ENG": 9, "LAM": 6, "ORTHO": 9, "ANISO": 21}
# Row and column of each constant in the order of the file; 11 22 33 12 13 23 count from 0.
_ORTHOTROPIC = (np.array([0, 0, 1, 0, 1, 2, 3, 4, 5]), np.array([0, 1, 1, 2, 2, 2, 3, 4, 5]))
_ANISOTROPIC = np.tril_indices(6)
