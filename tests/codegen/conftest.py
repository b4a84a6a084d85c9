"""Folders of C are written once in a run for all tests that ask for the same machine with the same
options.
"""

from functools import partial

import pytest

from helpers import firmware_tools, inside


@pytest.fixture(autouse=True, scope="session")
def _one_folder_of_a_kind(_shared_folders_of_c):
    """What `write_folder` makes of a mechanism with options is kept for the next test."""
    module = inside.codegen_folder
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            module, "folder_files", partial(firmware_tools.kept_files, module.folder_files)
        )
        yield
