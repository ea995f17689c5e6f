"""Reduced bodies for Exudyn: the file that its ObjectFFRFreducedOrderInterface loads.

Exudyn's nodal-based floating frame with modal reduction uses the inertia integrals of the Gram matrix
`ReducedBody.gram`; they are copied to the file. With the modes Psi, their cross matrices Psi~ and the cross
matrices x~ of the nodes, the fields of the Gram matrix are

    [Phi_t | Phi_w0 | Phi_k | V] = [Phi_t | -x~ | -Psi~ | Psi]

Exudyn's equations hold for point masses. For nodes with rotations and for rigid interfaces, they contain the
gyroscopic and centrifugal terms, and the terms with the angular acceleration to first order in the modes.

Source: [ZwoelferGerstmayr2021].
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.quantities import TensorModes
from supple.reduction import ReducedBody
from supple.storage.atomic_write import replacing

__all__ = ["exudyn_arrays", "interface_nodes", "write_exudyn"]


ARM = 0.01
"""Distance from an interface to each of its six nodes, as a fraction of the body's diagonal."""

_FILE_VERSION = 1
_EULER_PARAMETERS = 4


def write_exudyn(
    path: Path | str,
    body: ReducedBody,
    *,
    triangles: ArrayLike | None = None,
    stress: TensorModes | None = None,
) -> Path:
    """Write a linear reduced body as the .npz file that Exudyn loads; returns the path.

        reduced = ObjectFFRFreducedOrderInterface()
        reduced.LoadFromFile("blade.npz")
        reduced.AddObjectFFRFreducedOrder(mbs, gravity=[0, 0, -9.81])

    The file has no damping: give Exudyn the two Rayleigh factors when the object is added.

    Parameters
    ----------
    body : ReducedBody              linear, as Exudyn's reduced body is
    triangles : int array (T, 3)    surface to draw; by default none
    stress : TensorModes            at all nodes of a solid, for the display of stress in Exudyn

    Raises
    ------
    ModelError          as for exudyn_arrays; a path that does not end in .npz
    ResultFileError     the file cannot be written
    """
    path = Path(path)
    if path.suffix != ".npz":
        raise ModelError(f"cannot write {path}: Exudyn loads .npz files; end the path in .npz")
    arrays = exudyn_arrays(body, triangles=triangles, stress=stress)
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez(file, **arrays)
    return path


def exudyn_arrays(
    body: ReducedBody, *, triangles: ArrayLike | None = None, stress: TensorModes | None = None
) -> dict[str, Any]:
    """The arrays of write_exudyn by the names that Exudyn gives them.

    The N nodes of the mesh come first. Then each interface has six nodes without mass, two on each axis at a
    distance ARM from the interface. They move rigidly with it; joints are attached to them (interface_nodes).

    Raises
    ------
    ModelError      a nonlinear body; stress that is nonlinear, of a shell, or not of all nodes
    """
    if not body.is_linear:
        raise ModelError(
            f"body '{body.name}' is nonlinear and Exudyn's reduced body is linear: reduce body.linearized(), "
            "or remove the tensors by dataclasses.replace(body, cubic=None, quartic=None)"
        )
    r, gram = body.r, body.gram
    t, w, k, v = slice(0, 3), slice(3, 6), slice(6, 6 + 3 * r), slice(6 + 3 * r, None)
    arms = ARM * np.linalg.norm(np.ptp(body.nodes, axis=0)) * np.concatenate([np.eye(3), -np.eye(3)])
    nodes = np.concatenate([body.nodes, *(interface.position + arms for interface in body.interfaces)])
    modes = np.concatenate(
        [body.displacement_basis, *(_carried(interface.motion, arms) for interface in body.interfaces)]
    )
    mass = gram[0, 0]
    first_moment = -gram[t, w]
    centre = np.array([first_moment[2, 1], first_moment[0, 2], first_moment[1, 0]]) / mass
    couplings = gram[k, v].reshape(r, 3, r)
    skew = (couplings - couplings.transpose(2, 1, 0)) / 2  # antisymmetric for point masses
    return {
        "fileVersion": _FILE_VERSION,
        "type": "ObjectFFRFreducedOrderInterface",
        "rigidBodyNodeType": "NodeType.RotationEulerParameters",
        "infoList": np.array([r, len(nodes), 3, _EULER_PARAMETERS, 3 + _EULER_PARAMETERS, 7 + r]),
        "modeBasis": modes.reshape(-1, r),
        "xRef": nodes.ravel(),
        "trigList": np.zeros((0, 3), dtype=int) if triangles is None else np.asarray(triangles),
        "postProcessingModes": np.array(_stress_columns(body, stress), dtype=object),
        "massMatrixReduced": gram[v, v],
        "stiffnessMatrixReduced": body.stiffness,
        "Mtt": gram[t, t],
        "totalMass": mass,
        "chiU": centre,
        "chiUtilde": first_moment / mass,
        "inertiaLocal": gram[w, w],
        "mPhitTPsi": gram[t, v],
        "mPhitTPsiTilde": -gram[t, k],
        "mXRefTildePsi": -gram[w, v],
        "mXRefTildePsiTilde": gram[w, k],
        "mPsiTildePsi": -skew.reshape(3 * r, r),
        "mPsiTildePsiTilde": gram[k, k],
    }


def interface_nodes(body: ReducedBody, name: str) -> list[int]:
    """Numbers of the six nodes of an interface in the exported body; ModelError for an unknown interface.

    With equal weights the nodes give the position of the interface (MarkerSuperElementPosition, for a ball
    joint), or its position and rotation (MarkerSuperElementRigid).
    """
    body.interface(name)
    number = [interface.name for interface in body.interfaces].index(name)
    first = len(body.nodes) + 6 * number
    return list(range(first, first + 6))


def _carried(motion: FloatArray, arms: FloatArray) -> FloatArray:
    """Displacement modes (k, 3, r) of points at arms (k, 3) from an interface: u + theta x arm."""
    translation, rotation = motion[:3], motion[3:]
    return translation + np.cross(rotation.T, arms[:, None]).swapaxes(1, 2)


def _stress_columns(body: ReducedBody, modes: TensorModes | None) -> dict[str, Any]:
    """Exudyn's output modes: a row per node; the six components of mode 1, then of mode 2 and so on."""
    if modes is None:
        return {}
    n_nodes = len(body.nodes)
    if modes.quadratic is not None or not np.array_equal(modes.nodes, np.arange(n_nodes)):
        raise ModelError(
            f"body '{body.name}': give the stress modes of the same linear body at all of its {n_nodes} "
            "nodes, in their order: stress_modes(body, model)"
        )
    if modes.linear.shape[1] != 1:
        raise ModelError(
            f"body '{body.name}' is a shell with {modes.linear.shape[1]} layers of stress, and Exudyn shows "
            "one tensor per node; export it without stress"
        )
    columns = np.zeros((n_nodes + 6 * len(body.interfaces), 6 * body.r))
    columns[:n_nodes] = modes.linear[:, 0].swapaxes(1, 2).reshape(n_nodes, -1)
    return {"matrix": columns, "outputVariableType": "OutputVariableType.StressLocal"}
