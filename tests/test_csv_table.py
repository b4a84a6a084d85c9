"""CSV tables: what is written is read, units are converted, and every mistake names file, row and column."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symkin.csv_table import read_table, replace_text, write_table
from symkin.errors import InputError


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


@pytest.mark.parametrize("header", ["leg1 [m],theta [deg]", " leg1[m] , theta  [deg] "])
def test_a_space_may_stand_before_the_unit(tmp_path, header):
    """Names and units are those without the space."""
    read = table(tmp_path, f"{header}\n1,90\n")
    assert read.numbers("leg1", "length", "mm") == [1000.0]
    assert read.columns["theta"].unit == "deg"


def test_copies_are_rows_with_the_same_values(tmp_path):
    """A row that repeats an earlier one in every cell, however its numbers are written, is told with that one; others are not."""
    read = table(tmp_path, "group,leg1[m]\na,1\nb,1\na,1.0\na,1e0\na,1.01\n")
    assert read.copies() == ((2, 0), (3, 0))


@given(st.lists(st.tuples(st.floats(allow_nan=False, allow_infinity=False), st.integers()), max_size=5))
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
        ("a b,c\n", ["column 1", "a b"]),
        ("a[furlong]\n1\n", ["'a'", "furlong", "mm"]),
        ("a,a\n1,2\n", ["'a'", "twice"]),
        ("a,b\n1\n", ["line 2", "1 cells", "2"]),
        ('a,b\n1,"x\n', ["line 2", "CSV"]),
        ("a;b[mm]\n1;2\n", ["line 1", "separated by semicolons; commas are needed"]),
        ("a\tb[mm]\n1\t2\n", ["line 1", "separated by tabs; commas are needed"]),
        ("a,b\n1;2\n", ["line 2", "separated by semicolons"]),
        ("a,b\n1,5,2\n", ["line 2", "3 cells", "decimal commas"]),
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
        (lambda t: t.numbers("b"), ["line 2", "'b'", "''"]),
        (lambda t: t.numbers("c"), ["'c'", "missing", "a, n, b"]),
        (lambda t: t.refuse_unknown(["a", "b"]), ["'n'", "unknown", "a, b"]),
    ],
)
def test_mistakes_of_columns_are_sentences(tmp_path, call, words):
    """A cell or column that does not fit is refused with file, row and column."""
    t = table(tmp_path, "a[mm],n,b\n1,2,\nx,3,inf\n")
    with pytest.raises(InputError) as caught:
        call(t)
    assert all(word in str(caught.value) for word in ["data.csv", *words])


@pytest.mark.parametrize(("cell", "point"), [("0,213", "0.213"), ("-1,5e-3", "-1.5e-3"), (",5", ".5")])
def test_decimal_commas_are_named(tmp_path, cell, point):
    """A quoted number with a decimal comma is refused with the number that is meant."""
    with pytest.raises(InputError, match="has a decimal comma") as caught:
        table(tmp_path, f'a,b\n1,"{cell}"\n').numbers("b")
    assert str(caught.value).endswith(f"as in {point}")


def test_empty_cells_may_be_allowed(tmp_path):
    """Empty cells are nan where they are allowed, and only those."""
    values = table(tmp_path, "a,b\n1,\n2,3\n").numbers("b", empty=True)
    assert math.isnan(values[0])
    assert values[1] == 3.0


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    """Where a file cannot be written whole, what stood there stands, and nothing is left beside it."""
    path = tmp_path / "t.csv"
    replace_text(path, "old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(InputError, match="No space left"):
        replace_text(path, "new")
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
