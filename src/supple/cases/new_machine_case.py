"""A commented case file for a machine in a URDF or MJCF file, without drives."""

from __future__ import annotations

from pathlib import Path

from supple.machine import Cylindrical, Prismatic, Revolute, features_not_read, read_mujoco

__all__ = ["machine_case"]


def machine_case(name: str, named: str, file: Path) -> str:
    """Text of a case of the machine in a URDF or MJCF file, which the case names `named`."""
    left = features_not_read(file)
    machine = read_mujoco(file, leave_out=left)
    joints = [each for each in machine.joints if isinstance(each, Revolute | Prismatic | Cylindrical)]
    lines = ["", "# Its bodies and joints: supple info of this file."]
    if left:
        words = ", ".join(f'"{each}"' for each in left)
        lines[:0] = [
            f"leave_out = [{words}]   # GUESS: parts of the file that affect its motion and are not read"
        ]
    for joint in joints[:1]:
        kind = "slide-servo" if isinstance(joint, Prismatic) else "angle-servo"
        axis = ", ".join(f"{each:.6g}" for each in joint.axis)
        lines += [
            "",
            "# A drive, one for each joint; joints without a drive move freely:",
            "# [[element]]",
            f'# kind = "{kind}"',
            f'# name = "{joint.name} drive"',
            f'# first = "{joint.first}"',
            f'# second = "{joint.second}"',
            f"# axis = [{axis}]",
            '# law = { kind = "ramp", value = 0.5, duration = 1.0 }',
            "# stiffness = 100.0",
            "# damping = 10.0",
        ]
    more, body = "\n".join(lines), machine.bodies[-1].body.name
    return f"""\
# The machine of {named}. Check the lines marked GUESS.

title = "{name}"
units = {{ length = "m", mass = "kg", time = "s" }}

[machine]
mujoco = "{named}"
{more}

# A flexible body or further interfaces for a body of the file:
# [[body]]
# name = "{body}"
# interface = [{{ name = "tool", position = [0.1, 0.0, 0.0] }}]
{"".join(_motion(joint.name) for joint in joints)}
[simulation]
duration = 1.0       # GUESS
output_step = 0.01   # GUESS: at least ten per period of the motion of interest
step = 0.001         # GUESS: compare with half of it
"""


def _motion(joint: str) -> str:
    return f"""
[[sensor]]
name = "{joint}"
kind = "joint-motion"
joint = "{joint}"
"""
