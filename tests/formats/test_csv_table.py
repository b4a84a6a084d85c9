"""CSV tables: what is written is read, units are converted, and every mistake names file, row and
column.
"""

import math
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.inside import read_table, write_output, write_table
from symkin import InputError


def table(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text)
    return read_table(path)


def test_units_convert(tmp_path):
    """A value in one unit of a kind is the same value in another one."""
    t = table(tmp_path, "# a note\na[mm], b[deg],group\n1500,180,first\n\n-2,90,second\n")
    assert t.numbers("a", "length", "m") == pytest.approx([1.5, -0.002], rel=1e-15)
    assert t.numbers("a", "length", "mm") == [1500.0, -2.0]
    assert t.numbers("b", "angle", "rad") == pytest.approx([math.pi, math.pi / 2], rel=1e-15)
    assert t.text("group") == ("first", "second")
    assert t.lines == (3, 5)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_what_is_no_regular_file_is_refused(tmp_path):
    """A FIFO would wait for ever for one who writes, a device would never end."""
    os.mkfifo(tmp_path / "pipe.csv")
    for place in (tmp_path / "pipe.csv", "/dev/zero"):
        with pytest.raises(InputError, match="no regular file"):
            read_table(place)


@pytest.mark.parametrize("header", ["leg1 [m],theta [deg]", " leg1[m] , theta  [deg] "])
def test_a_space_may_stand_before_the_unit(tmp_path, header):
    """Names and units are those without the space."""
    read = table(tmp_path, f"{header}\n1,90\n")
    assert read.numbers("leg1", "length", "mm") == [1000.0]
    assert read.columns["theta"].unit == "deg"


def test_copies_are_rows_with_the_same_values(tmp_path):
    """A row that repeats an earlier one in every cell, however its numbers are written, is told
    with that one; others are not.
    """
    read = table(tmp_path, "group,leg1[m]\na,1\nb,1\na,1.0\na,1e0\na,1.01\n")
    assert read.copies() == ((2, 0), (3, 0))


@given(
    st.lists(st.tuples(st.floats(allow_nan=False, allow_infinity=False), st.integers()), max_size=5)
)
def test_written_numbers_are_read(tmp_path_factory, rows):
    """Reading what was written gives the same doubles."""
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    write_table(path, ["x[mm]", "n"], rows)
    back = read_table(path)
    assert back.numbers("x", "length", "mm") == [x for x, _ in rows]
    assert back.text("n") == tuple(str(n) for _, n in rows)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["data.csv", "empty"]),
        ("a,a\n1,2\n", ["'a'", "twice"]),
        ("a,b\n1\n", ["line 2", "1 cells", "2"]),
        ('a,b\n1,"x\n', ["line 2", "CSV"]),
        ("a,b\n1;2\n", ["line 2", "looks separated by semicolons, the header by commas"]),
        ("a,b\n1,5,2\n", ["line 2", "3 cells", "decimal commas"]),
        ("a;b,c\n1;2,3\n", ["commas and semicolons stand in the header"]),
        ("1,2\n3,4\n", ["line 1", "numbers where a header", "leg1[mm]"]),
        ("Log of May 3\n\na,b\n1,2\n", ["line 3", "2 cells", "header", "begins with #"]),
        ("PK\3\4", ["spreadsheet", "CSV"]),
    ],
)
def test_mistakes_of_a_file_are_sentences(tmp_path, text, words):
    """A file that is no table is refused with its place."""
    with pytest.raises(InputError) as caught:
        table(tmp_path, text)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda t: t.numbers("a", "length", "mm"), ["line 3", "a[mm]", "'x'", "number"]),
        (lambda t: t.numbers("n", "length", "mm"), ["'n'", "unit", "n[m]"]),
        (lambda t: t.numbers("a"), ["a[mm]", "plain"]),
        (lambda t: t.numbers("b"), ["line 2", "'b'", "an empty cell"]),
        (lambda t: t.numbers("c"), ["'c'", "missing", "a, n, b"]),
        (lambda t: t.matched(["A", "_a"]), ["'a'", "'A' or '_a'", "meant"]),
    ],
)
def test_mistakes_of_columns_are_sentences(tmp_path, call, words):
    """A cell or column that does not fit is refused with file, row and column."""
    t = table(tmp_path, "a[mm],n,b\n1,2,\nx,3,inf\n")
    with pytest.raises(InputError) as caught:
        call(t)
    assert all(word in str(caught.value) for word in ["data.csv", *words])


VALUES = [[344.182, -0.5, 1e-3], [1344.25, 2.0, -7.0]]
NAMES, UNITS = ("leg1", "theta", "x"), ("mm", "deg", "mm")


def people(separator=",", point=".", header="{name}[{unit}]", end="\n", before="", quoted=False):
    """The same numbers as some program writes them."""
    mark = '"' if quoted else ""
    rows = [[header.format(name=n, unit=u) for n, u in zip(NAMES, UNITS, strict=True)]]
    rows += [[f"{mark}{v!r}{mark}".replace(".", point) for v in row] for row in VALUES]
    return before + "".join(separator.join(row) + end for row in rows)


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        (people(), []),
        (people(header="{name} [{unit}]", end="\r\n", before="\ufeff"), []),
        (people(";"), ["separated by semicolons"]),
        (people(";", ","), ["separated by semicolons", "decimal commas"]),
        (people("\t", ",", end="\r\n"), ["separated by tabs", "decimal commas"]),
        (people(",", ",", quoted=True), ["decimal commas"]),
        (people(header="{name} ({unit})"), ["'leg1 (mm)' as leg1[mm]"]),
        (people(header="{name} / {unit}"), ["'theta / deg' as theta[deg]"]),
        (people(";", ",", before="sep=;\n", end=";\n"), ["separated by semicolons"]),
        (
            people().replace("leg1[mm]", "Leg1(MM)").replace("theta[deg]", "THETA[\u00b0]"),
            ["'Leg1(MM)' as leg1[mm]", "'THETA[\u00b0]' as theta[deg]"],
        ),
        (
            people().replace("leg1[mm]", '"Leg 1, (mm)"').replace("Leg 1,", "Leg-1"),
            ["'Leg-1 (mm)' as leg1[mm]"],
        ),
        (
            people(end=",note, 3 of 4\n")
            .replace("]\n", "]\n")
            .replace("x[mm],note, 3 of 4", "x[mm],Remark,Temp (C)"),
            ["'Remark', 'Temp (C)'"],
        ),
    ],
)
def test_files_as_people_have_them(tmp_path, text, notes):
    """However separators, points, units and names are written, the numbers are the same, and what
    was unusual is said.
    """
    path = tmp_path / "data.csv"
    path.write_bytes(text.encode())
    read = read_table(path).matched(NAMES)
    kinds = ("length", "angle", "length")
    columns = [read.numbers(n, k, u) for n, k, u in zip(NAMES, kinds, UNITS, strict=True)]
    assert [list(row) for row in zip(*columns, strict=True)] == VALUES
    assert all(any(words in note for note in read.notes) for words in notes)
    assert bool(read.notes) == bool(notes)


@pytest.mark.parametrize("blank", ["NaN", "nan", "N/A", "#NV", "null", ""])
def test_what_programs_write_for_nothing_is_blank(tmp_path, blank):
    """NaN and its like are blank cells, as empty ones are, and counted in a note."""
    read = table(tmp_path, f"a[mm],b\n{blank},1\n2,3\n").matched(["a", "b"])
    assert math.isnan(read.numbers("a", "length", "mm", empty=True)[0])
    assert read.notes == (("1 cell with NaN or its like was read as blank",) if blank else ())
    with pytest.raises(InputError, match=r"line 2, column 'a.mm.': an empty cell"):
        read.numbers("a", "length", "mm")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "a[mm];b[mm]\n1,5;2.5\n",
            ["'a[mm]' has '1,5'", "'b[mm]' has '2.5'", "decimal or separate thousands"],
        ),
        ("a[mm]\tb[mm]\n1,500\t22,125\n", ["'1,500'", "every comma"]),
        ('a[mm],b[mm]\n"1,500",2\n', ["'1,500'", "every comma"]),
        ("A[mm],a [mm],b\n1,2,3\n", ["'a'", "'A'", "leave one out"]),
    ],
)
def test_what_can_be_read_in_two_ways_is_refused(tmp_path, text, words):
    """One sentence with the cells that leave it open."""
    with pytest.raises(InputError) as caught:
        table(tmp_path, text).matched(["a", "b"])
    assert all(word in str(caught.value) for word in words)


def test_text_stays_as_it_is(tmp_path):
    """Labels with points and commas are no numbers: they neither change nor decide what a comma
    means.
    """
    read = table(tmp_path, "group;a[mm]\n1.2;3,5\n1,2;4,5\n").matched(
        ["group", "a"], text=["group"]
    )
    assert read.text("group") == ("1.2", "1,2")
    assert read.numbers("a", "length", "mm") == [3.5, 4.5]


def test_windows_text_is_read(tmp_path):
    """A file that is no UTF-8 is read as Windows-1252, which is said."""
    path = tmp_path / "w.csv"
    path.write_bytes("a[\u00b5m],Gr\u00f6\u00dfe\n5,x\n".encode("cp1252"))
    read = read_table(path).matched(["a"])
    assert read.numbers("a", "length", "mm") == [0.005]
    assert any("Windows-1252" in note for note in read.notes)


def test_unknown_units_are_refused_where_they_matter(tmp_path):
    """Of a column that is read, not of one that is left out."""
    read = table(tmp_path, "a[furlong],T[C]\n1,2\n").matched(["a"])
    with pytest.raises(InputError, match=r"'a\[furlong\]' needs a unit of length.*mm"):
        read.numbers("a", "length", "mm")


def test_empty_cells_may_be_allowed(tmp_path):
    """Empty cells are nan where they are allowed, and only those."""
    values = table(tmp_path, "a,b\n1,\n2,3\n").numbers("b", empty=True)
    assert math.isnan(values[0])
    assert values[1] == 3.0


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    """Where a file cannot be written whole, what stood there stands, and nothing is left beside
    it.
    """
    path = tmp_path / "t.csv"
    write_output(path, "old")
    monkeypatch.setattr(
        "os.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device"))
    )
    with pytest.raises(InputError, match="No space left"):
        write_output(path, "new")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["t.csv"]
    with pytest.raises(InputError, match="cannot be written"):
        write_table(tmp_path / "nowhere" / "t.csv", ["a"], [])


def test_unreadable_files_are_refused(tmp_path):
    """A missing file and a file of bytes are refused by name."""
    with pytest.raises(InputError, match=r"nothing\.csv"):
        read_table(tmp_path / "nothing.csv")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"b\.csv.*UTF-8"):
        read_table(tmp_path / "b.csv")
