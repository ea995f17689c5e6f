"""Contents of values as bytes, for digests: result files of different runs have different digests."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from supple.body import FlexibleBody
from supple.fem import FiniteElementModel
from supple.storage.run_inputs import digest_of
from supple.value_content import content_of


def digest_of_parts(parts: Iterable[bytes]) -> str:
    """A digest of parts, each with its length, so that different lists of parts have different digests."""
    return digest_of(b"".join(b"%d:%b" % (len(part), part) for part in parts))


def bytes_of(value: Any) -> Iterator[bytes]:
    """The content of a value, such as a joint, a load, a body or a law (`content_of`).

    A finite element model is represented by its input, because another number of threads changes the last
    digits of its matrices.
    """
    return content_of(value, _made_of)


def _made_of(value: Any) -> Any:
    """The parts that represent a value, or the value itself."""
    match value:
        case FiniteElementModel():
            return value.mesh, value.sections, value.kinematics, value.attached, value.dofs_per_node
        case FlexibleBody() if value.model is not None:
            ends = [
                (own.name, own.position, own.node_ids, own.cubic_turn, own.tied_nodes)
                for own in value.interfaces
            ]
            return value.name, value.model, value.is_linear, ends
        case _:
            return value
