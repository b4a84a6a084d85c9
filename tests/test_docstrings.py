"""Examples in docstrings of public names do what they show."""

import doctest
import inspect

import pytest

import symkin

RUN = doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL


def examples() -> dict[str, doctest.DocTest]:
    """The examples of public functions and classes, their methods included, by their names."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found: dict[str, doctest.DocTest] = {}
    for name in symkin.__all__:
        value = getattr(symkin, name)
        if inspect.isclass(value) or inspect.isfunction(value):
            module = inspect.getmodule(value)
            found |= {test.name: test for test in finder.find(value, name, module) if test.examples}
    return found


EXAMPLES = examples()


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_of_docstrings_hold(name):
    """Each example gives what the docstring says."""
    told: list[str] = []
    doctest.DocTestRunner(optionflags=RUN).run(EXAMPLES[name], out=told.append)
    assert not told, "".join(told)


@pytest.mark.parametrize("name", ["DHRow", "DHTable", "Example", "Joint", "Limb", "Mechanism", "Pose", "Rod", "RodLimb", "load"])
def test_names_of_the_model_have_an_example(name):
    """The classes with which mechanisms are described, and `load`, show how they are used."""
    assert any(found == name or found.startswith(f"{name}.") for found in EXAMPLES)
