"""The grammar of Nastran cards: forms of fields, continuations, sections, includes; and what breaks it."""

from __future__ import annotations

import pytest

from supple.errors import ImportFormatError
from supple.importers.nastran.bulk_data import bulk_real, integer_column, read_bulk_data, real_column


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
LATE = "GRID    7,  3, 1.5, 2.0, 3.0, 4, 123"
TABS = "GRID\t7\t3\t1.5\t2.0\t3.0\t4\t123"


@pytest.mark.parametrize(
    "text", [SMALL, LARGE, FREE, LATE, TABS], ids=["small", "large", "free", "late", "tabs"]
)
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
        ("+,7,8\n", r"line 1: a continuation without a card"),
        (
            f"{'GRID           1':72}+A\n+B             7\n",
            r"line 2: continues '\+B', which no card announces; is a line missing",
        ),
        ("<html>\n", r"line 1: '<html>' is not the name of a card; is this a Nastran"),
        ("GRID,1,2,3,4,5,6,7,8,9,10\n", r"line 1: 11 fields; a line has a name, 8 of them and a label"),
        ("=,*(1)\n", "line 1: '=' repeats the card above, and there is none"),
        ("GRID,1,,0.\n=,*(1),,*(x)\n", r"line 2: '\*\(x\)' adds to '0\.'; both must be numbers"),
        ("GRID,1\n=,*(1)\n=9999999\n", "line 3: '=9999999' repeats over"),
        ("RBE2,1,2,3,4,5,6,7,8,9\n", r"line 1: '9' is in the field of the continuation label; write it on"),
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


@pytest.mark.parametrize(
    "lines",
    [
        ("=,*(1),=,*(0.5),==", "=(2)"),
        ("=,*1,=,*.5,==", "=2"),
        ("=       *(1)    =       *(0.5)  ==", "=(2)"),
    ],
    ids=["free", "without brackets", "small"],
)
def test_replication(read, lines):
    cards = read("\n".join(["GRID,5,7,1.,2.,,8", *lines, "GRID,20"])).cards
    assert [card.integer(0, "id") for card in cards] == [5, 6, 7, 8, 20]
    assert [card.real(2, "x") for card in cards[:4]] == [1.0, 1.5, 2.0, 2.5]
    assert {card.fields[1:2] + card.fields[3:6] for card in cards[:4]} == {("7", "2.", "", "8")}


def test_labels_find_their_continuation_in_any_order_and_case(read):
    head = f"{'CHEXA          1       1       1       2       3       4       5       6':72}"
    parts = [
        f"{head}+aB",
        "GRID,9",
        f"{'+CD           11      12':72}",
        f"{'+Ab            7       8       9      10      13      14      15      16':72}+cd",
    ]
    file = read("\n".join(parts))
    assert [card.name for card in file.cards] == ["CHEXA", "GRID"]
    assert fields(file.cards[0])[8:] == ["7", "8", "9", "10", "13", "14", "15", "16", "11", "12"]


def test_a_label_without_its_plus(read):
    """Column 73 of the label is the place of its '+'."""
    head = f"{'CHEXA          1       1       1       2       3       4       5       6':72}"
    (card,) = read(f"{head}XAB\n+AB            7       8\n").cards
    assert fields(card)[-2:] == ["7", "8"]


@pytest.mark.parametrize(
    ("end", "ended"), [("ENDDATA 1b2c\nGRID,9\n", True), ("enddata,x\n", True), ("", False)]
)
def test_the_end_of_the_cards(read, end, ended):
    """Checksums stand behind it; a punched file has none."""
    file = read(f"BEGIN BULK\nGRID,1\n{end}")
    assert [card.integer(0, "id") for card in file.cards] == [1]
    assert file.ended is ended


def test_parts_stand_beside_the_residual(read):
    text = "SOL 101\nCEND\nSPC = 2\nBEGIN BULK\nGRID,1\nBEGIN SUPER=3\nGRID,2\nBEGIN BULK SUPER = 4\nGRID,3\n"
    file = read(text + "ENDDATA\n")
    assert [card.fields[0] for card in file.cards] == ["1"]
    assert {part: of.cards[0].fields[0] for part, of in file.parts.items()} == {
        ("SUPER", "3"): "2",
        ("SUPER", "4"): "3",
    }
    assert file.above == ("SOL 101", "CEND", "SPC = 2")


@pytest.mark.parametrize("name", ["'PART.INC'", "'HERE:part.inc'", "'sub/../Part.inc'"])
def test_included_files_are_found_by_other_spellings(read, tmp_path, name):
    """In any case of letters, behind a logical name, from a folder below in that of the main file."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "part.inc").write_text("GRID,2\n")
    (tmp_path / "sub" / "below.inc").write_text(f"INCLUDE {name}\n")
    for text in (f"INCLUDE {name}\n", "INCLUDE 'sub/below.inc'\n", f"INCLUDE\n  {name}\n"):
        assert [card.integer(0, "id") for card in read(text).cards] == [2]


def test_columns_of_many_cards(read):
    cards = read("GRID,1,,1.5+1\nGRID,2\n").cards
    assert integer_column(cards, 0, "the id").tolist() == [1, 2]
    assert real_column(cards, 2, "X1", 0.25).tolist() == [15.0, 0.25]
    with pytest.raises(ImportFormatError, match=r"line 2: GRID: X1 \(field 4\) is blank"):
        real_column(cards, 2, "X1")
    with pytest.raises(ImportFormatError, match=r"line 1: GRID: X1 \(field 4\) is '1.5\+1', not a whole"):
        integer_column(cards, 2, "X1", 0)


def test_what_is_skipped(read):
    cards = read("GRID,1\nSKIPON\nGRID,2\nSKIPOFF\n/ 5\nGRID,3\n").cards
    assert [card.integer(0, "id") for card in cards] == [1, 3]


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


def test_what_nastran_reads_leniently_is_read(tmp_path):
    """Blanks part free fields; a step from a blank field; lists that go on without a mark; control files."""
    text = (
        "SOL 103\nINCLUDE 'not_there.dmap'\nCEND\nBEGIN BULK\n"
        "PSHEAR, 401     1       1.0     0.5, 1.,30.\n"
        "GRID,   123,    1,      25.,    -60.4,  0.,\n=,      *(1),   =,      =,      *(14.8),=,      *(1)\n"
        "BSURF, 1,1050,1133,1146,1125,1143,1055,\n1054,1002,1025\nENDDATA\n"
    )
    (tmp_path / "deck.bdf").write_text(text)
    file = read_bulk_data(tmp_path / "deck.bdf")
    (panel,) = file.named("PSHEAR")
    assert panel.fields[:6] == ("401", "1", "1.0", "0.5", "1.", "30.")
    grids = file.named("GRID")
    assert [card.word(0) for card in grids] == ["123", "124"]
    assert (float(grids[1].word(3)), grids[1].word(5)) == (pytest.approx(-45.6), "1")
