"""A case that goes on from an instant of the run of another one."""

import numpy as np
import pytest
from fixtures.bar_of_every_form import HINGE, LIFT, PERIOD, RUN, write_case

from supple.cases import read_case, run_case
from supple.errors import CaseError, ModelError, UnitsWarning
from supple.storage import read_solution

TIME = float(PERIOD / 2)
GOES_ON = f'step = 5e-4\nstart = {{ file = "before/bar.h5", time = {TIME!r} }}'


def case(folder, *changes, form="reduced"):
    """The bar on its sprung hinge, lifted at its tip, as a case in a folder."""
    folder.mkdir(exist_ok=True)
    path = write_case(folder, form, HINGE, LIFT, RUN)
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return read_case(path)


@pytest.fixture(scope="module")
def before(tmp_path_factory):
    """A folder with a run of the bar in it, `before/bar.h5`."""
    folder = tmp_path_factory.mktemp("going-on")
    run_case(case(folder), folder / "before", errors=False)
    return folder


def test_the_run_goes_on_at_its_time_as_if_there_were_no_break(before):
    told = []
    later = case(before, ("step = 5e-4", GOES_ON))
    object.__setattr__(later, "notify", lambda text, *_: told.append(text))
    found = run_case(later, before / "after", errors=False).solution
    through = read_solution(before / "before" / "bar.h5")
    assert found.times[0] == TIME
    assert found.times[:11] == pytest.approx(through.times[10:], abs=1e-12)
    for what in ("position", "rotation", "coordinates"):
        here, there = (getattr(each.bodies["bar"], what) for each in (found, through))
        assert here[0] == pytest.approx(there[10], abs=1e-13)
        assert here[:11] == pytest.approx(there[10:], abs=1e-5 * np.abs(there).max())
    assert any(line.startswith("starts from before/bar.h5 at t = ") for line in told)


@pytest.mark.slow
def test_on_another_basis_and_in_other_units_the_loss_is_stated(before):
    told = []
    more = ("modes = 6", "modes = 8")
    changed = case(before, ("step = 5e-4", GOES_ON), more)
    object.__setattr__(changed, "notify", lambda text, *_: told.append(text))
    run_case(changed, before / "more modes", errors=False)
    (line,) = [line for line in told if line.startswith("starts from")]
    assert "body 'bar' is projected on its basis, which lacks " in line
    unsaid = case(before, ("step = 5e-4", GOES_ON), ('units = { length = "m", mass = "kg", time = "s" }', ""))
    with pytest.raises(CaseError, match=r"before/bar\.h5 gives its unit of length, and "):
        run_case(unsaid, before / "no units", errors=False)
    # Said to be in mm, the mesh is not the one that moved.
    small = case(before, ("step = 5e-4", GOES_ON), ('length = "m"', 'length = "mm"'))
    with pytest.warns(UnitsWarning), pytest.raises(ModelError, match="another mesh"):
        run_case(small, before / "mm", errors=False)


def test_mistakes_are_named_with_their_lines(before):
    def refused(words, *changes):
        with pytest.raises(CaseError, match=words):
            case(before, *changes)

    refused("there is no file", ("step = 5e-4", GOES_ON.replace("before", "nowhere")))
    refused(
        r"simulation\.start\.time: this key is missing",
        ("step = 5e-4", GOES_ON.partition(", time")[0] + " }"),
    )
    refused("did you mean 'equilibrium'", ("step = 5e-4", 'step = 5e-4\nstart = "equilibrum"'))
    refused("remove the key", ("step = 5e-4", GOES_ON + "\nassemble = true"))
    refused("the joints define the start", ("step = 5e-4", GOES_ON + "\nkinematic = true"))
    late = case(before, ("step = 5e-4", GOES_ON.replace(repr(TIME), repr(TIME + 1e-4))))
    with pytest.raises(ModelError, match="is not among those from 0 to"):
        run_case(late, before / "late", errors=False)
