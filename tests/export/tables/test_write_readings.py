"""Tables of readings are read back by other programs' readers as they were, to what the format holds."""

import csv
import struct
import sys

import h5py
import numpy as np
import pytest
from scipy.io import loadmat

from supple.errors import MissingPackageError, ModelError
from supple.export import TABLE_SUFFIXES, write_readings
from supple.quantities import Channel, QuantityKind, Reading, Readings
from supple.units import SI

TIMES = np.linspace(0.5, 2.5, 41)


def reading(name, values, channels=("x", "y"), quantity=QuantityKind.LENGTH, times=TIMES):
    made = tuple(Channel(each, quantity, "global") for each in channels)
    return Reading(name, made, times, np.asarray(values))


@pytest.fixture
def readings():
    """A swing, and a force that hardly changes beside its size."""
    swing = np.column_stack([np.sin(TIMES), 1e3 * np.cos(3 * TIMES)])
    force = 7e6 + 1e-3 * TIMES[:, None]
    return Readings([reading("tip", swing), reading("pull", force, ("",), QuantityKind.FORCE)])


HEADS = ["Time_[s]", "tip.x_[m]", "tip.y_[m]", "pull_[N]"]


def table(readings):
    return np.column_stack([TIMES, *(each.values for each in readings)])


def read_outb(path):
    """After OpenFAST's description of its binary output."""
    data = path.read_bytes()
    kind, length, n, t = struct.unpack_from("<hhii", data)
    start, step = struct.unpack_from("<dd", data, 12)
    scale, offset = np.frombuffer(data, "<f4", 2 * n, 28).reshape(2, n).astype(float)
    at = 28 + 8 * n
    (described,) = struct.unpack_from("<i", data, at)
    at += 4 + described
    words = [data[at + length * k : at + length * (k + 1)].decode().strip() for k in range(2 * (n + 1))]
    packed = np.frombuffer(data, "<i2", n * t, at + length * 2 * (n + 1)).reshape(t, n)
    assert kind == 4
    assert at + length * 2 * (n + 1) + packed.nbytes == len(data)
    values = np.column_stack([start + step * np.arange(t), (packed - offset) / scale])
    return [
        f"{name}_[{unit[1:-1]}]" for name, unit in zip(words[: n + 1], words[n + 1 :], strict=True)
    ], values


def test_text_has_all_digits(readings, tmp_path):
    with write_readings(tmp_path / "a.csv", readings, units=SI).open(newline="") as file:
        heads, *rows = csv.reader(file)
    assert heads == HEADS
    np.testing.assert_array_equal(np.array(rows, dtype=float), table(readings))


def test_openfast_files_are_off_by_what_their_16_bits_hold(readings, tmp_path):
    heads, values = read_outb(write_readings(tmp_path / "a.outb", readings, units=SI))
    assert heads == HEADS
    off, expected = abs(values - table(readings)).max(axis=0), table(readings)
    assert off[0] < 1e-12
    assert (off[1:3] < np.ptp(expected, axis=0)[1:3] / 130_000 * 1.01).all()
    assert off[3] < 2e-8 * 7e6
    assert off[3] > 0


def test_openfasts_own_tools_read_them(readings, tmp_path):
    weio = pytest.importorskip("weio.fast_output_file")
    path = write_readings(tmp_path / "a.outb", readings, units=SI)
    frame = weio.FASTOutputFile(str(path)).toDataFrame()
    assert list(frame.columns) == HEADS
    np.testing.assert_allclose(frame.values, read_outb(path)[1], rtol=0, atol=1e-12 * 7e6)


@pytest.mark.parametrize("values", [np.zeros((41, 2)), np.full((41, 2), -3e-5), np.full((41, 2), 1e30)])
def test_columns_that_do_not_change_are_packed(values, tmp_path):
    path = write_readings(tmp_path / "a.outb", [reading("a", values)], units=SI)
    np.testing.assert_allclose(read_outb(path)[1][:, 1:], values, rtol=2e-8, atol=0)


@pytest.mark.parametrize(
    ("times", "values", "name", "cause"),
    [
        (TIMES**2, np.zeros((41, 2)), "a", "equally spaced"),
        (TIMES, np.full((41, 2), np.nan), "a", "column 'a.x' has numbers that are not finite"),
        (TIMES, np.zeros((41, 2)), "Flügel", "ASCII"),
    ],
)
def test_what_an_openfast_file_cannot_hold_is_refused(times, values, name, cause, tmp_path):
    with pytest.raises(ModelError, match=cause):
        write_readings(tmp_path / "a.outb", [reading(name, values, times=times)], units=SI)
    assert not list(tmp_path.iterdir())


def test_one_output_time_is_a_table_too(tmp_path):
    one = reading("a", np.array([[1.0, 2.0]]), times=np.array([3.0]))
    for suffix in TABLE_SUFFIXES:
        if suffix != ".nc":
            assert write_readings(tmp_path / f"a{suffix}", [one]).stat().st_size
    assert read_outb(tmp_path / "a.outb")[1] == pytest.approx(np.array([[3.0, 1.0, 2.0]]), rel=2e-8)


def test_matlab_files(readings, tmp_path):
    found = loadmat(write_readings(tmp_path / "a.mat", readings, units=SI))
    np.testing.assert_array_equal(found["values"], table(readings)[:, 1:])
    np.testing.assert_array_equal(found["time"][:, 0], TIMES)
    assert [str(cell[0]) for cell in found["names"][0]] == ["tip.x", "tip.y", "pull"]
    assert [str(cell[0]) for cell in found["units"][0]] == ["m", "m", "N"]
    assert found["time_unit"][0] == "s"


def test_netcdf_files(readings, tmp_path):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(write_readings(tmp_path / "a.nc", readings, units=SI)) as found:
        np.testing.assert_array_equal(found["tip.y"], readings[0].values[:, 1])
        np.testing.assert_array_equal(found["time"], TIMES)
        assert found["tip.y"].attrs == {"units": "m", "axes": "global"}
        assert found["time"].attrs["units"] == "s"
    with pytest.raises(ModelError, match="netCDF allows no '/'"):
        write_readings(tmp_path / "b.nc", [reading("a/b", np.zeros((41, 2)))])


def test_hdf5_files(readings, tmp_path):
    with h5py.File(write_readings(tmp_path / "a.h5", readings, units=SI)) as file:
        np.testing.assert_array_equal(file["tip"], readings[0].values)
        assert list(file["tip"].attrs["units"]) == ["m", "m"]


def test_data_frames(readings):
    pytest.importorskip("pandas")
    frame = readings.to_pandas(SI)
    assert [frame.index.name, *frame.columns] == HEADS
    np.testing.assert_array_equal(frame.to_numpy(), table(readings)[:, 1:])


def test_a_missing_package_is_named(readings, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingPackageError, match=r"the package pandas, .* pip install 'supple\[xarray\]'"):
        readings.to_pandas()


def test_names_differ_and_suffixes_are_known(tmp_path):
    same = [reading("a", np.zeros((41, 1)), ("b.c",)), reading("a.b", np.zeros((41, 1)), ("c",))]
    with pytest.raises(ModelError, match=r"two columns would be named 'a.b.c'"):
        write_readings(tmp_path / "a.csv", same)
    with pytest.raises(ModelError, match="named 'Time'"):
        write_readings(tmp_path / "a.csv", [reading("Time", np.zeros((41, 1)), ("",))])
    with pytest.raises(ModelError, match=r"no table format has the suffix '.xls'.*\.csv, \.h5"):
        write_readings(tmp_path / "a.xls", same)
    assert not list(tmp_path.iterdir())
