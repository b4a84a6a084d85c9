"""One record of options: what the verb takes, what a file's fit takes and what the command offers
are the same.
"""

from __future__ import annotations

import inspect

import pytest

import symkin
from helpers.inside import app, fit_file
from symkin import InputError, calibrate

FIT = app.get_command(None, "calibrate").get_command(None, "fit")
OFFERED = {parameter.name: parameter for parameter in FIT.params}
ARM = symkin.load("scara")
READINGS = symkin.Measurements([[0.1, 0.2, 0.3, 0.4]], position=[[1.0, 2.0, 3.0]])


def defaults(verb) -> dict[str, object]:
    """The options of a verb with their defaults."""
    parameters = inspect.signature(verb).parameters.values()
    return {p.name: p.default for p in parameters if p.default is not p.empty}


def test_the_command_offers_what_a_file_is_fitted_by() -> None:
    """Every option of `fit_file` but those of the record alone and what the command says itself."""
    own = {"level", "max_iterations", "sigmas", "command"}
    assert set(defaults(fit_file)) - own <= set(OFFERED)


def test_defaults_are_the_same_everywhere() -> None:
    """Of the verb, of a file's fit and of the command, words with a dash for a space."""
    verb, of_files = defaults(calibrate), defaults(fit_file)
    assert {k: v for k, v in verb.items() if k != "fixed"} == {
        k: of_files[k] for k in verb.keys() - {"fixed"}
    }
    for name in of_files.keys() & OFFERED.keys():
        assert OFFERED[name].default == of_files[name], name


@pytest.mark.parametrize("name", ["method", "residual", "outliers", "loss"])
def test_a_word_that_is_none_is_refused_with_those_that_are(name: str) -> None:
    with pytest.raises(InputError, match=rf"{name} = 'mean' is unknown.*allowed|did you mean"):
        calibrate(ARM, READINGS, **{name: "mean"})


def test_a_name_that_is_no_option_is_refused() -> None:
    with pytest.raises(TypeError, match="iterations"):
        calibrate(ARM, READINGS, iterations=3)
