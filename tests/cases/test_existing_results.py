"""Results in a folder that a new run must not replace, and a part that cannot be built."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from supple.cases import read_case
from supple.cases.explicit_parts import ExplicitPart
from supple.cases.run_files import refuse_overwrite, result_path
from supple.error import ROUNDS_FOLDER
from supple.errors import ModelError, ResultFileError
from supple.storage import ResultFile


def test_rounds_beside_a_result_without_times_are_not_replaced(case_folder, tmp_path):
    case = read_case(case_folder / "strip.toml")
    ResultFile.create(result_path(case.path, tmp_path), case=case.text).close()
    refuse_overwrite(case, tmp_path, resume=False, force=False)
    (tmp_path / ROUNDS_FOLDER).mkdir()
    (tmp_path / ROUNDS_FOLDER / "round-0.npz").touch()
    with pytest.raises(ResultFileError, match="the rounds of an interrupted run"):
        refuse_overwrite(case, tmp_path, resume=False, force=False)
    refuse_overwrite(case, tmp_path, resume=False, force=True)


def test_an_explicit_part_of_laminates_alone_has_no_material_for_its_law():
    model = SimpleNamespace(sections=(SimpleNamespace(property="a laminate"),))
    with pytest.raises(ModelError, match="explicit part 'crate': its law needs an isotropic material"):
        ExplicitPart().build("crate", model, None)
