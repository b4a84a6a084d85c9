"""A release can be made: versions and dependencies agree in every file that says them, the citation
and the workflow are valid.
"""

from __future__ import annotations

import datetime
import importlib.util
import re
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

import symkin

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
RECIPE = yaml.safe_load((ROOT / "recipe" / "recipe.yaml").read_text())
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text())
WORKFLOW = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text())
CONDA_NAMES = {"matplotlib": "matplotlib-base"}
"""Packages that conda knows by another name."""


def script(name):
    """A script of .ci as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / ".ci" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def requirement(text):
    """Name and the set of bounds of a requirement."""
    name, bounds = re.fullmatch(r"([\w-]+)\s*(.*)", text).groups()
    return name, frozenset(bounds.replace(" ", "").split(",")) - {""}


def pythons():
    """The versions of Python that the classifiers name."""
    found = (
        re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", text)
        for text in PROJECT["classifiers"]
    )
    return [match[1] for match in found if match]


def test_recipe_has_the_dependencies_of_the_project():
    wanted = {requirement(text) for text in PROJECT["dependencies"]}
    wanted = {(CONDA_NAMES.get(name, name), bounds) for name, bounds in wanted}
    run = {requirement(text) for text in RECIPE["requirements"]["run"]}
    assert run == wanted | {requirement("python" + PROJECT["requires-python"])}
    host = {requirement(text)[0] for text in RECIPE["requirements"]["host"]}
    assert host == {"python", "pip", "setuptools"}


def test_recipe_says_what_the_project_says():
    assert RECIPE["about"]["summary"] == PROJECT["description"]
    assert RECIPE["about"]["license"] == PROJECT["license"]
    (entry,) = RECIPE["build"]["python"]["entry_points"]
    assert dict([entry.split(" = ")]) == PROJECT["scripts"]


def test_every_file_says_the_same_version():
    release = script("release")
    assert release.version() == symkin.__version__
    assert set(release.said_elsewhere(None).values()) == {symkin.__version__}
    assert RECIPE["context"]["version"] == CITATION["version"] == symkin.__version__


def test_another_tag_is_refused(monkeypatch, tmp_path):
    """One sentence, before anything is built; a tag needs its heading in the changelog."""
    monkeypatch.setattr("sys.argv", ["release.py", "--tag", "v9.9.9", "-o", str(tmp_path)])
    with pytest.raises(
        SystemExit, match=r"^release: symkin/_version.py says .*the tag says 9\.9\.9"
    ):
        script("release").main()
    assert not list(tmp_path.iterdir())


def test_what_is_unreleased_gets_a_heading_first():
    """A tag is refused while the newest heading of the changelog is another, "Unreleased" too."""
    said = script("release").said_elsewhere(f"v{symkin.__version__}")
    newest = next(
        line for line in (ROOT / "CHANGELOG.md").read_text().splitlines() if line.startswith("## ")
    )
    assert said["the newest heading of CHANGELOG.md"] == newest.removeprefix("## ")
    assert said["the tag"] == symkin.__version__


def test_citation_is_valid():
    """The keys that the Citation File Format 1.2.0 requires, its date and its licence."""
    assert CITATION["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= set(CITATION)
    assert CITATION["type"] in ("software", "dataset")
    assert all(
        "name" in author or {"family-names", "given-names"} <= set(author)
        for author in CITATION["authors"]
    )
    assert isinstance(CITATION["date-released"], datetime.date)
    assert CITATION["license"] == PROJECT["license"]
    told = PROJECT.get("urls", {})
    assert CITATION.get("repository-code") == told.get("Source")


def test_the_workflow_runs_the_gate_on_each_python():
    gate = WORKFLOW["jobs"]["gate"]
    assert gate["strategy"]["matrix"]["python"] == pythons()
    assert pythons()[0] == PROJECT["requires-python"].removeprefix(">=")
    assert "bash .ci/run" in [step.get("run") for step in gate["steps"]]


def test_actions_are_pinned_by_commit():
    used = [
        step["uses"] for job in WORKFLOW["jobs"].values() for step in job["steps"] if "uses" in step
    ]
    assert used
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", name) for name in used)
    assert WORKFLOW["permissions"] == {"contents": "read"}


def test_a_wheel_that_lacks_a_file_is_refused(tmp_path):
    lost = "symkin/py.typed"
    release = script("release")
    files = release.package_files()
    assert lost in files
    with zipfile.ZipFile(tmp_path / "symkin.whl", "w") as wheel:
        for name in files - {lost}:
            wheel.writestr(name, "")
    tarfile.open(tmp_path / "symkin.tar.gz", "w:gz").close()
    with pytest.raises(SystemExit, match=r"the wheel lacks .*py\.typed"):
        release.checked(tmp_path)
