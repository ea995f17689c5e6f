"""What an explicit run depends on, and which modes its motion is of: how a result file knows its run."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from supple.errors import ResultFileError
from supple.explicit.engine import ExplicitOptions
from supple.explicit.explicit_system import ExplicitSystem, Part
from supple.explicit.modal_subdomain import ModalSubdomain
from supple.integrate import Run
from supple.storage.column_measures import KEY, measures, same_measures
from supple.storage.result_content import Metadata, ResultHeader
from supple.storage.run_inputs import Inputs
from supple.storage.value_bytes import bytes_of, digest_of_parts

__all__ = ["check_modes", "inputs_of", "modes_of"]


def inputs_of(system: ExplicitSystem, run: Run, options: ExplicitOptions) -> Inputs:
    """The run and the options in words; digests of parts, ties, contacts, supports, forces and gravity.

    Of modes only what they are made from, for another number of threads moves their last digits and signs:
    `modes_of` knows these.
    """
    span = f"{run.duration!r} from {run.start!r}, every {run.output_step!r}"
    found = {"the run": span, "the step": repr(run.step)}
    found |= {f"the option {item.name}": repr(getattr(options, item.name)) for item in fields(options)}
    found["the order of the parts"] = ", ".join(part.name for part in system.placed)
    found |= {f"part '{part.name}'": digest_of_parts(_of_part(part)) for part in system.placed}
    for kind in ("ties", "contacts", "supports", "forces"):
        found |= {
            f"{kind[:-1]} {number} of '{each.nodes}'": digest_of_parts(bytes_of(each))
            for number, each in enumerate(getattr(system, kind), 1)
        }
    return found | {"gravity": digest_of_parts(bytes_of(system.gravity))}


def modes_of(system: ExplicitSystem) -> Metadata:
    """Metadata that tell the modes of modal parts apart: products with a random vector, and frequencies."""
    known = {part.name: dict(_measures(part.subdomain)) for part in _modal(system)}
    listed = {part: {name: values.tolist() for name, values in own.items()} for part, own in known.items()}
    return {KEY: json.dumps(listed)} if listed else {}


def check_modes(header: ResultHeader, system: ExplicitSystem, path: Path) -> None:
    """ResultFileError where the modes of a system are others than those of a result file."""
    known = json.loads(str(header.metadata.get(KEY, "{}")))
    for part in _modal(system):
        then = known.get(part.name, {})
        for name, now in _measures(part.subdomain):
            if name in then and not same_measures(then[name], now):
                raise ResultFileError(
                    f"{path} holds a motion of part '{part.name}' in {len(then[name])} modes whose {name} "
                    f"are not those of the part given, which has {part.subdomain.n_modes}. On another "
                    "computer, or with another number of threads, modes of like frequency come out turned: "
                    "go on there, or start anew"
                )


def _modal(system: ExplicitSystem) -> list[Any]:
    return [part for part in system.placed if isinstance(part.subdomain, ModalSubdomain)]


def _of_part(part: Part) -> Iterator[bytes]:
    yield from bytes_of((part.position, part.rotation, part.velocity, part.angular_velocity))
    body = part.subdomain
    if isinstance(body, ModalSubdomain):
        yield from bytes_of((body.body, body.mass_damping, body.stiffness_damping))
        yield from bytes_of((body.n_modes, body.spin_stiffness is not None))
    else:
        yield from bytes_of(body)


def _measures(body: ModalSubdomain) -> Iterator[tuple[str, np.ndarray]]:
    yield "shapes", measures(body.vectors)
    yield "frequencies", body.frequencies
    if body.spin_stiffness is not None:
        yield "stiffness under spin", measures(body.spin_stiffness.reshape(-1, body.n_modes))
