"""Build the files of a release, sdist and wheel, and check them: `release.py [--tag vX.Y.Z] [-o
DIR]`.

Version, tag, changelog, citation and recipe must agree; the wheel, built from the sdist, has every
file of the package and no other.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tarfile
import zipfile

ROOT = pathlib.Path(__file__).parents[1]


def version() -> str:
    found = re.search(
        r'^__version__ = "([^"]+)"$', (ROOT / "symkin" / "_version.py").read_text(), re.M
    )
    if found is None:
        sys.exit('release: symkin/_version.py has no line __version__ = "..."')
    return found[1]


def said_elsewhere(tag: str | None) -> dict[str, str]:
    """The version by each file that repeats it, and by the tag."""
    found = {"recipe/recipe.yaml": r'^  version: "(.+)"$', "CITATION.cff": r"^version: (.+)$"}
    said = {}
    for name, pattern in found.items():
        match = re.search(pattern, (ROOT / name).read_text(), re.M)
        said[name] = match[1] if match else "none"
    if tag is not None:
        said["the tag"] = tag.removeprefix("v") if tag.startswith("v") else tag
        heading = re.search(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
        said["the newest heading of CHANGELOG.md"] = heading[1] if heading else "none"
    return said


def package_files() -> set[str]:
    """Files of the package that are tracked, or that stand there where this is no repository."""
    git = subprocess.run(
        ["git", "ls-files", "symkin"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if git.returncode == 0 and git.stdout:
        return set(git.stdout.split())
    every = (
        path
        for path in (ROOT / "symkin").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    )
    return {path.relative_to(ROOT).as_posix() for path in every}


def checked(folder: pathlib.Path) -> None:
    """Ends with a sentence where a file of the package is missing in the wheel, or more is in
    it.
    """
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as archive:
        inside = {name for name in archive.namelist() if ".dist-info/" not in name}
    wanted = package_files()
    if inside != wanted:
        sys.exit(
            f"release: the wheel lacks {sorted(wanted - inside)} and has besides "
            f"{sorted(inside - wanted)}"
        )
    with tarfile.open(sdist) as archive:
        names = {name.split("/", 1)[-1] for name in archive.getnames()}
    if not wanted | {"pyproject.toml", "README.md", "LICENSE"} <= names:
        sys.exit(f"release: the sdist lacks {sorted(wanted - names)}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Build and check the files of a release.")
    parser.add_argument("--tag", help="the tag of the release, vX.Y.Z")
    parser.add_argument(
        "-o",
        type=pathlib.Path,
        default=pathlib.Path("dist"),
        metavar="DIR",
        help="where to write (default: dist)",
    )
    given = parser.parse_args()
    own = version()
    other = {name: said for name, said in said_elsewhere(given.tag).items() if said != own}
    if other:
        sys.exit(
            f"release: symkin/_version.py says {own}, but "
            + ", ".join(f"{name} says {said}" for name, said in other.items())
        )
    if given.o.exists() and any(given.o.iterdir()):
        sys.exit(f"release: {given.o} is not empty; name an empty folder by -o")
    subprocess.run(
        [sys.executable, "-m", "build", "--outdir", str(given.o), str(ROOT)],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    checked(given.o)
    subprocess.run(
        [sys.executable, "-m", "twine", "check", "--strict", *map(str, sorted(given.o.iterdir()))],
        check=True,
    )


if __name__ == "__main__":
    main()
