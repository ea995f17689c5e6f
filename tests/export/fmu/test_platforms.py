"""Libraries for other systems: of the right format, with the functions of the standard and no others."""

from __future__ import annotations

import zipfile

import pytest
from fixtures.exported_machines import linked, run

from supple.errors import ModelError
from supple.export.fmu import platforms
from supple.export.fmu.platforms import PLATFORMS, compilers_of
from supple.export.fmu.write_fmu import write_fmu
from supple.machine import System
from supple.quantities import PositionSensor
from supple.stepping import step_program

BEGINNINGS = {
    "binaries/x86_64-linux/machine.so": b"\x7fELF\x02\x01",
    "binaries/aarch64-linux/machine.so": b"\x7fELF\x02\x01",
    "binaries/x86_64-windows/machine.dll": b"MZ",
    "binaries/x86_64-darwin/machine.dylib": b"\xcf\xfa\xed\xfe\x07\x00\x00\x01",
    "binaries/aarch64-darwin/machine.dylib": b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01",
}
"""Format, and of Mach-O the kind of processor."""
MACHINES = {"x86_64": 0x3E, "aarch64": 0xB7}
"""Of ELF."""


@pytest.mark.slow
def test_an_fmu_has_libraries_for_all_platforms(tmp_path, monkeypatch):
    pytest.importorskip("ziglang")
    monkeypatch.setenv("CFLAGS", "-O1")
    bodies, joints = linked(1)
    step = step_program(System(bodies, joints), run(), [PositionSensor("tip", "l0.b")])
    every = tuple(each for kinds in PLATFORMS.values() for each in kinds)
    path = write_fmu(tmp_path / "machine.fmu", step, "machine", platforms=every)
    with zipfile.ZipFile(path) as archive:
        found = {name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")}
    assert found.keys() == BEGINNINGS.keys()
    for name, data in found.items():
        assert data.startswith(BEGINNINGS[name])
        assert b"fmi3DoStep\0" in data
        # Hidden: two FMUs in one process do not meet. (Mach-O keeps names of local functions.)
        assert name.endswith(".dylib") or b"machine_advance" not in data
        if name.endswith(".so"):
            assert data[18] == MACHINES[name.split("/")[1].partition("-")[0]]


def test_fmi_2_has_no_name_for_arm():
    pytest.importorskip("ziglang")
    every = tuple(each for kinds in PLATFORMS.values() for each in kinds)
    folders = [each.platform.folders[2] for each in compilers_of(every, 2)]
    assert folders == ["linux64", "win64", "darwin64"]


def test_a_missing_cross_compiler_is_named(monkeypatch):
    monkeypatch.setattr(platforms.importlib.util, "find_spec", lambda _: None)
    with pytest.raises(ModelError, match=r"supple\[fmu\]"):
        compilers_of(PLATFORMS["windows"], 3)
