"""Values of other packages' types at the border of the verbs: names are honoured, what is no
list of real numbers is refused in a sentence.
"""

from collections import OrderedDict

import numpy as np
import pytest

import symkin

JOINTS = {"theta1": 81.6, "theta2": 202.8, "theta3": 330.6, "op": 105.2}
MODES = 4  # Zhao, Li, Gao et al. 2000


class Series:
    """What a pandas Series shows of itself: keys, values by key; iterated, the values."""

    def __init__(self, values):
        self.values = dict(values)

    def keys(self):
        return self.values.keys()

    def __getitem__(self, key):
        return self.values[key]

    def __iter__(self):
        return iter(self.values.values())

    def __len__(self):
        return len(self.values)


def _backwards(values):
    return OrderedDict(reversed(values.items()))


@pytest.fixture(scope="module")
def platform():
    return symkin.load("zhao2000")


def test_names_of_a_table_are_honoured(platform):
    """A row, a row given by names, columns, a list of rows, a column without names: each the same
    modes, whatever the order.
    """
    row, columns = (
        Series(_backwards(JOINTS)),
        Series(_backwards({name: np.array([v, v]) for name, v in JOINTS.items()})),
    )
    right = symkin.modes(platform, joints=JOINTS).to_dict()["modes"]
    assert len(right) == MODES
    found = [
        symkin.modes(platform, joints=row),
        symkin.modes(platform, given=row),
        *symkin.modes(platform, joints=columns),
        *symkin.modes(platform, joints=[row, row]),
        symkin.modes(platform, joints=Series(enumerate(JOINTS.values()))),
        symkin.modes(platform, joints=(value for value in JOINTS.values())),
    ]
    assert [one.to_dict()["modes"] for one in found] == [right] * len(found)
    assert symkin.solve(platform, joints=row).solution is not None
    assert symkin.track(platform, joints=[row, row]).stop is None


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (set(JOINTS.values()), "is no list of numbers"),
        (bytearray(b"abcd"), "is no list of numbers"),
        ("1234", "is no list of numbers"),
        (["81.6", 202.8, 330.6, 105.2], "value 1 = '81.6' is not a number"),
        (np.array([*JOINTS.values()]) * (1 + 1j), "is not a number"),
        (
            np.array([[*JOINTS.values()]]) * (1 + 1j),
            "input 0: .* value 1 = .* is not a number",
        ),
        (np.array([np.nan, 1, 2, 3]), "value 1 = nan is not finite"),
        (np.array([[1e200, 1, 2, 3]]), "value 1 = 1e\\+200 is too large to compute with"),
        ([10**400, 1, 2, 3], "value 1 = a whole number of 1329 bits is too large to compute with"),
        ([[10**400, 1, 2, 3]], "input 0: joints: value 1 = .* is too large to compute with"),
    ],
)
def test_what_is_no_list_of_real_numbers_is_refused(platform, joints, message):
    with pytest.raises(symkin.InputError, match=message):
        symkin.modes(platform, joints=joints)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda _: symkin.mobility("zhao2000"), "symkin.load\\('zhao2000'\\) gives it"),
        (lambda p: symkin.mobility(p, seed="abc"), "seed = 'abc'; a whole number"),
        (lambda p: symkin.modes(p, seed="abc"), "seed = 'abc'; a whole number"),
        (lambda p: symkin.mobility(p, seed=-1), "seed = -1 is negative; whole numbers from 0"),
        (lambda p: symkin.modes(p, seed=-1), "seed = -1 is negative; whole numbers from 0"),
        (lambda p: symkin.modes(p, starts=1500.0), "starts = 1500.0; a whole number"),
        (lambda p: symkin.modes(p, choose=3), "choose = 3 is no list of whole numbers"),
        (lambda p: symkin.modes(p, solver=5), "solver = 5 is unknown"),
        (lambda p: symkin.solve(p, solver=5), "solver = 5 is unknown"),
        (lambda p: symkin.singularity(p, tolerance="1"), "tolerance = '1'; a number"),
        (lambda _: symkin.load(None), "name_or_path = None; a path or a name"),
        (lambda _: symkin.close(3), "name_or_path = 3; a path or a name"),
        (lambda p: symkin.convert(p, 3), "path = 3; a path"),
    ],
)
def test_an_option_that_cannot_be_is_named(platform, ask, message):
    with pytest.raises(symkin.InputError, match=message):
        ask(platform)


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000", "ur5e", "klann_leg", "delta"])
def test_numpy_that_raises_its_errors_changes_nothing(name):
    """Verbs judge their numbers themselves, whatever `np.seterr` says."""
    mechanism = symkin.load(name)
    plain = symkin.modes(mechanism).to_dict()["modes"]
    before = np.seterr(all="raise")
    try:
        assert symkin.modes(mechanism).to_dict()["modes"] == plain
    finally:
        np.seterr(**before)
