"""Folders compared byte by byte."""

import filecmp


def same_files(a, b):
    """Whether two folders hold the same files with the same bytes."""
    compared = filecmp.dircmp(a, b)
    if compared.left_only or compared.right_only or compared.funny_files:
        return False
    _, different, broken = filecmp.cmpfiles(a, b, compared.common_files, shallow=False)
    return (
        not different
        and not broken
        and all(same_files(a / name, b / name) for name in compared.common_dirs)
    )
