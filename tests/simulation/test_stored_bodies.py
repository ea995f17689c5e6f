"""A run is resumed with the bodies it began with, not with others that were reduced again."""

from __future__ import annotations

from dataclasses import replace

from supple.machine import Placed, System
from supple.simulation import store_bodies, with_stored_bodies
from supple.storage import read_reduced_body


def test_kept_bodies_replace_those_reduced_again(tmp_path, floating_blade, clamped_blade, rod):
    other = replace(clamped_blade, name="other")
    begun = System(bodies=(Placed(floating_blade), Placed(other), Placed(rod("rod", 1.0))))
    store_bodies(begun, {"blade", "rod"}, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["blade-reduced.h5"]
    again = System(bodies=(Placed(clamped_blade), Placed(other), Placed(rod("rod", 1.0))))
    resumed = with_stored_bodies(again, {"blade"}, tmp_path)
    assert str(resumed.bodies[0].body.frame) == str(floating_blade.frame)
    assert resumed.bodies[1:] == again.bodies[1:]


def test_a_body_that_was_not_kept_is_kept_when_the_run_goes_on(tmp_path, clamped_blade):
    system = System(bodies=(Placed(clamped_blade),))
    assert with_stored_bodies(system, {"blade"}, tmp_path).bodies[0].body is clamped_blade
    assert read_reduced_body(tmp_path / "blade-reduced.h5").r == clamped_blade.r
