"""The grammar of Nastran cards: forms of fields, continuations, sections, includes; and what breaks it."""

from __future__ import annotations

import pytest

from supple.errors import ImportFormatError
from supple.importers.nastran.bulk_data import bulk_real, read_bulk_data


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        path = tmp_path / "model.bdf"
        path.write_text(text)
        return read_bulk_data(path)

    return read_text


def fields(card):
    return [word for word in card.fields if word]


SMALL = "GRID           7       3 1.50000     2.0     3.0       4     123"
LARGE = """\
GRID*                  7               3             1.5             2.0
*                    3.0               4             123"""
FREE = "GRID,7,3,1.5,2.0,3.0,4,123"
TABS = "GRID\t7\t3\t1.5\t2.0\t3.0\t4\t123"


@pytest.mark.parametrize("text", [SMALL, LARGE, FREE, TABS], ids=["small", "large", "free", "tabs"])
def test_all_forms_of_fields_say_the_same(read, text):
    (card,) = read(text + "\n").cards
    assert card.name == "GRID"
    assert card.integer(0, "id") == 7
    assert [card.real(i, "x") for i in (2, 3, 4)] == [1.5, 2.0, 3.0]
    assert (card.integer(1, "CP"), card.integer(5, "CD"), card.word(6)) == (3, 4, "123")
    assert card.word(50) == ""


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("1.5+3", 1500),
        ("-1.5-3", -0.0015),
        ("1.5D3", 1500),
        ("1.5E+3", 1500),
        (".7", 0.7),
        ("7.", 7),
        ("2+1", 20),
    ],
)
def test_numbers_as_nastran_writes_them(word, value):
    assert bulk_real(word) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("word", ["nan", "inf", "1_0", "1_0.5", "1.5.2", "E5", "THRU", "1.5+3+2"])
def test_words_that_are_no_numbers(word):
    with pytest.raises(ValueError):
        bulk_real(word)


def test_continuations_of_all_kinds(read):
    text = """\
CHEXA          1       1       1       2       3       4       5       6+A
+A             7       8
CHEXA,2,1,1,2,3,4,5,6
,7,8
CHEXA          3       1       1       2       3       4       5       6
               7       8
"""
    for number, card in enumerate(read(text).cards, 1):
        assert fields(card) == [str(word) for word in (number, 1, 1, 2, 3, 4, 5, 6, 7, 8)]


def test_sections_comments_and_includes(read, tmp_path):
    (tmp_path / "part.inc").write_text("$ a comment\nGRID,2  $ another\n\nINCLUDE 'deep.inc'\n")
    (tmp_path / "deep.inc").write_text("GRID,3\n")
    file = read("SOL 103\nCEND\nSPC = 1\nBEGIN BULK\nGRID,1\ninclude 'part.inc'\nGRID,4\nENDDATA\nGRID,5\n")
    assert [card.integer(0, "id") for card in file.named("GRID")] == [1, 2, 3, 4]
    assert [(card.path.name, card.line) for card in file.cards] == [
        ("model.bdf", 5),
        ("part.inc", 2),
        ("deep.inc", 1),
        ("model.bdf", 7),
    ]


def test_a_parameter_may_stand_in_case_control(read):
    text = "SOL 103\nCEND\nSPC = 1\n param, WTMASS, .01\nPARAM POST = 1\nBEGIN,BULK\nGRID,1\nENDDATA\n"
    assert [(card.name, *fields(card)) for card in read(text).cards] == [
        ("PARAM", "WTMASS", ".01"),
        ("GRID", "1"),
    ]


@pytest.mark.parametrize("name", ["'sub/part.inc'", "sub/part.inc", '"sub\\part.inc"', "'sub/\n  part.inc'"])
def test_names_of_included_files(read, tmp_path, name):
    """Quoted or not, from Windows, and over two lines."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "part.inc").write_text("GRID,2\n")
    file = read(f"GRID,1\nINCLUDE {name}\nGRID,3\n")
    assert [card.integer(0, "id") for card in file.cards] == [1, 2, 3]


def test_line_ends_of_windows(tmp_path):
    (tmp_path / "model.bdf").write_bytes(
        f"{SMALL}\r\n$ comment\r\n{LARGE}\r\n".replace("\n*", "\r\n*").encode()
    )
    assert [fields(card) for card in read_bulk_data(tmp_path / "model.bdf").cards] == [
        ["7", "3", "1.50000", "2.0", "3.0", "4", "123"],
        ["7", "3", "1.5", "2.0", "3.0", "4", "123"],
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("BEGIN BULK\nGRID,1\n", r"model\.bdf, line 1: BEGIN BULK, but no ENDDATA.*cut short"),
        ("BEGIN BULK\nBEGIN SUPER=2\nENDDATA\n", r"line 2: parts \(BEGIN SUPER\).*export each"),
        ("+,7,8\n", r"line 1: a continuation without a card"),
        (
            f"{'GRID           1':72}+A\n+B             7\n",
            r"line 2: GRID: continues 'B', but the line above announces 'A'",
        ),
        ("<html>\n", r"line 1: '<html>' is not the name of a card; is this a Nastran"),
        ("GRID,1,2,3,4,5,6,7,8,9,10\n", r"line 1: 11 fields; a line has at most 10"),
        ("RBE2,1,2,3,4,5,6,7,8,9\n", r"line 1: '9' stands where only a continuation label may; write it on"),
        ("GRID*,1,2,3,4,5,6\n", r"line 1: 7 large fields; a line has a name, 4"),
        ("INCLUDE 'model.bdf'\n", "does a file include itself"),
        (
            "GRID,1\nINCLUDE 'absent.bdf'\n",
            r"model\.bdf, line 2: includes .*absent\.bdf, and there is no such",
        ),
        ("INCLUDE 'absent.bdf\n", r"model\.bdf, line 1: includes .*absent\.bdf, and there is no such file"),
        (
            "PSHELL* 7               5               .1              5\n+                               2.\n",
            "line 2: PSHELL: small fields continue a single large line; write a row as two large lines",
        ),
    ],
)
def test_what_breaks_the_grammar_is_named_with_its_line(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)


def test_a_binary_file_is_recognised(tmp_path):
    (tmp_path / "model.op2").write_bytes(b"\x04\x00\x00\x00\x03\x00")
    with pytest.raises(ImportFormatError, match=r"model\.op2: a binary file.*export the model as text"):
        read_bulk_data(tmp_path / "model.op2")


def test_fields_that_are_no_numbers_or_blank(read):
    (card,) = read("GRID,one,,1.0.0\n").cards
    with pytest.raises(ImportFormatError, match=r"line 1: GRID: the id \(field 2\) is 'ONE', not a whole"):
        card.integer(0, "the id")
    with pytest.raises(ImportFormatError, match=r"X1 \(field 4\) is '1\.0\.0', not a number"):
        card.real(2, "X1")
    (grouped,) = read("GRID,1_0\n").cards
    with pytest.raises(ImportFormatError, match=r"the id \(field 2\) is '1_0', not a whole number"):
        grouped.integer(0, "the id")
    with pytest.raises(ImportFormatError, match=r"CP \(field 3\) is blank; give a whole number"):
        card.integer(1, "CP")
    with pytest.raises(ImportFormatError, match=r"X2 \(field 5\) is blank; give a number"):
        card.real(3, "X2")
