"""States of controllers at the start of a run, and their transfer from one part of a run to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from urllib.parse import quote

import jax
import numpy as np

from supple.arrays import AnyArray
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import ControlState, ControlStep, SystemMotion
from supple.equations.control_force import stepped
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.machine import Controller, JointReading, SampledController, System
from supple.programs.program_cache import CachedProgram


def fresh_control(system: System) -> ControlState | None:
    """Controllers before a run, with zero outputs of sampled controllers."""
    if not system.controllers:
        return None
    states, rates, held, memory = [], [], [], []
    for controller in system.controllers:
        sampled = isinstance(controller, SampledController)
        own = np.zeros(0) if sampled else np.array(controller.initial)
        angles = [reading.near for reading in controller.reads.values() if isinstance(reading, JointReading)]
        states.append(np.concatenate([own, np.array(angles)]))
        rates.append(np.zeros(len(own)))
        shapes = {name: element.value_shape for name, element in controller.drives.items()}
        held.append({name: np.zeros(shape) for name, shape in shapes.items()} if sampled else {})
        memory.append(dict(controller.memory) if sampled else {})
    return ControlState(tuple(states), tuple(rates), tuple(held), tuple(memory))


def first_control(system: System, model: Model, instant: SystemMotion) -> ControlState | None:
    """Controllers at the start: angles of joints, and rates of the states."""
    fresh = fresh_control(system)
    if fresh is None:
        return None
    return control_after(model, instant._replace(control=ControlStep(fresh, np.zeros(()))))


def control_after(model: Model, motion: SystemMotion) -> ControlState:
    """Controllers at the end of the step that led to a motion."""
    return jax.tree.map(np.asarray, _stepped(model, motion))


_stepped = CachedProgram(stepped, STARTING)


def kept_control(model: Model, control: ControlState | None) -> dict[str, np.ndarray]:
    """Controller states by the names of the controllers, for result files."""
    if control is None:
        return {}
    names = [law.name for law in model.controllers]
    return {name: np.asarray(leaf) for name, leaf in _named(control, names)}


def kept_states(
    known: Mapping[str, np.ndarray], controller: Controller
) -> tuple[np.ndarray, np.ndarray] | None:
    """The states of a controller, and the angles of joints that it reads, from `kept_control`.

    None if they are unknown, or if their numbers differ.
    """
    name, n = _key(controller.name), len(controller.initial)
    states, rates = (known.get(f"control.{item}.{name}") for item in ("states", "rates"))
    n_joints = sum(isinstance(reading, JointReading) for reading in controller.reads.values())
    if states is None or rates is None or (len(rates), len(states)) != (n, n + n_joints):
        return None
    return np.asarray(states)[:n], np.asarray(states)[n:]


def resumed_control(system: System, known: Mapping[str, np.ndarray]) -> ControlState | None:
    """The stored controller states; ModelError if their names or shapes are not those of the system's."""
    fresh = fresh_control(system)
    if fresh is None:
        return None
    names = [name for name, _ in _named(fresh, [controller.name for controller in system.controllers])]
    leaves, structure = jax.tree.flatten(fresh)
    for name, leaf in zip(names, leaves, strict=True):
        if name not in known or np.shape(known[name]) != np.shape(leaf):
            raise ModelError(
                "the recorded part was made with other controllers, or without: it cannot be continued; "
                "start a new run"
            )
    return jax.tree.unflatten(structure, [np.asarray(known[name]) for name in names])


def _named(control: ControlState, controllers: Sequence[str]) -> list[tuple[str, AnyArray]]:
    """Leaves in their order, each with a name such as "control.memory.CONTROLLER.integral"."""
    found, _ = jax.tree_util.tree_flatten_with_path(control)
    named = []
    for (item, number, *rest), leaf in found:
        words = [_word(item), _key(controllers[number.idx]), *map(_word, rest)]
        named.append((".".join(["control", *words]), leaf))
    return named


def _key(controller: str) -> str:
    """The name without characters that divide names."""
    return quote(controller, safe=" ").replace(".", "%2E")


def _word(key: object) -> str:
    return str(next(getattr(key, name) for name in ("name", "idx", "key") if hasattr(key, name)))
