"""CSV tables: columns, comments, and the error messages."""

import pytest

from supple.errors import ImportFormatError
from supple.importers.csv_table import read_csv_table


@pytest.fixture
def read(tmp_path):
    def of(text):
        (tmp_path / "t.csv").write_text(text)
        return read_csv_table(tmp_path / "t.csv", required=("a", "b"), optional=("c",))

    return of


def test_columns_in_any_order(read):
    table = read("# comment\nb, a\n\n1,x\n2.5e-1,y\n")
    assert table.columns["a"] == ("x", "y")
    assert table.numbers("b").tolist() == [1.0, 0.25]
    assert "c" not in table


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("a\n1\n", "no column b; its columns are a"),
        ("a,b,d\n1,2,3\n", "unknown column 'd'; known columns are a, b, c"),
        ("a,b,a\n1,2,3\n", "a second column 'a'"),
        ("a,b\n\n1,2\n3\n", "line 4: 1 values for 2 columns"),
    ],
)
def test_table_errors(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)


def test_words_for_numbers(read):
    with pytest.raises(ImportFormatError, match="line 3: b is 'two'; write a number"):
        read("a,b\n1,1\n2,two\n").numbers("b")


def test_missing_file(tmp_path):
    with pytest.raises(ImportFormatError, match="no such file"):
        read_csv_table(str(tmp_path / "none.csv"), required=("a",))
