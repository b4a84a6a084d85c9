"""The examples in the docstrings of public verbs run and print what they say."""

from __future__ import annotations

import doctest

import pytest

import symkin

VERBS = ("jacobian", "mode_graph", "singular_loci", "singularity", "track")


@pytest.mark.usefixtures("kept_starts")
@pytest.mark.parametrize("name", VERBS)
def test_the_example_of_a_verb_runs(name: str) -> None:
    """Every verb has an example, and its output is the one that is written there."""
    verb = getattr(symkin, name)
    (example,) = doctest.DocTestFinder(recurse=False).find(verb, name, globs={})
    assert example.examples
    assert doctest.DocTestRunner(verbose=False).run(example).failed == 0
