"""A plate from Nastran bulk data, clamped at one edge: deflection under gravity and lowest frequency.

The program writes a bulk data file of CQUAD4 shells and reads it. Properties and clamped nodes (SPC1) come
from the file.

Expected, by beam theory for a narrow plate and within 1.5 %: the free edge deflects by
`rho g A L^4 / (8 E I)`, and the lowest frequency is `3.516 sqrt(E I / (rho A L^4)) / (2 pi)`.
Run it: `python examples/nastran_plate.py` draws the plate in its equilibrium to nastran_plate.png.
"""

from pathlib import Path

import numpy as np

import supple as sp
from supple import machine as m
from supple.body import deck_body
from supple.importers import read_deck
from supple.reduction import CraigBampton

LENGTH, WIDTH, THICKNESS, G = 0.6, 0.06, 0.002, 9.81
YOUNGS_MODULUS, POISSONS_RATIO, DENSITY = 2.1e11, 0.0, 7850.0
ALONG, ACROSS = 24, 2


def bulk_data() -> str:
    """Bulk data of the plate."""
    lines = [
        "BEGIN BULK",
        f"MAT1,1,{YOUNGS_MODULUS:.1E},,{POISSONS_RATIO},{DENSITY}",
        f"PSHELL,1,1,{THICKNESS},1,,1",
    ]
    ids = np.arange(1, (ALONG + 1) * (ACROSS + 1) + 1).reshape(ALONG + 1, ACROSS + 1)
    for (i, j), number in np.ndenumerate(ids):
        lines.append(f"GRID,{number},,{LENGTH * i / ALONG:.6f},{WIDTH * j / ACROSS:.6f},0.0")
    corners = [ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]]
    for number, nodes in enumerate(np.stack([own.ravel() for own in corners], axis=1), 1):
        lines.append(f"CQUAD4,{number},1," + ",".join(map(str, nodes)))
    lines.append("SPC1,1,123456," + ",".join(map(str, ids[0])))
    return "\n".join([*lines, "ENDDATA", ""])


def main(picture: Path = Path("nastran_plate.png")) -> tuple[float, float]:
    """Sag of the free edge, m, and the lowest frequency, Hz."""
    file = picture.with_name("plate.bdf")
    file.write_text(bulk_data())
    body = deck_body("plate", read_deck(file), [sp.RigidInterface("root", "spc1_123456")]).linearized()
    mesh = body.model.mesh
    plate = sp.reduce(body, sp.MeanAxisFrame(), CraigBampton(n_modes=8), derivatives=sp.NoDerivatives())
    clamp = m.Fixed(first="ground", second="plate.root")
    system = sp.System([plate], [clamp], gravity=np.array([0, 0, -G]))

    found = sp.equilibrium(system)
    tip = np.argmax(mesh.nodes[:, 0])
    sag = float(-found.system.bodies[0].positions([tip])[0, 2])
    lowest = float(sp.machine_modes(sp.linearize(system), 1).frequencies[0]) / (2 * np.pi)
    bending = YOUNGS_MODULUS * WIDTH * THICKNESS**3 / 12
    line = DENSITY * WIDTH * THICKNESS
    print(f"sags by {1e3 * sag:.4g} mm, vibrates at {lowest:.4g} Hz")
    assert np.isclose(sag, line * G * LENGTH**4 / (8 * bending), rtol=1.5e-2)
    assert np.isclose(lowest, 3.516 * np.sqrt(bending / (line * LENGTH**4)) / (2 * np.pi), rtol=1.5e-2)

    from supple.viz import draw_machine

    draw_machine(picture, found.system, found.solution, {"plate": mesh})
    return sag, lowest


if __name__ == "__main__":
    main()
