"""What the shell completes: mechanisms and the values of options. Where nothing fits, shells go on
with the names of files.
"""

from __future__ import annotations

from pathlib import Path


def mechanism_names(incomplete: str) -> list[str]:
    """Shipped mechanisms and files in this folder that begin with `incomplete`; no files without a
    mechanism, since shells complete folders better.
    """
    from symkin.formats.load import is_robot
    from symkin.model.shipped import shipped_names

    names = [name for name in shipped_names() if name.startswith(incomplete)]
    files = (
        [path.name for path in Path().iterdir() if path.suffix == ".toml" or is_robot(path)]
        if names
        else []
    )
    return [*names, *sorted(name for name in files if name.startswith(incomplete))]
