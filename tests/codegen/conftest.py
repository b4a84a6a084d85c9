"""Folders of C are written once in a run for all tests that ask for the same machine with the same
options, and what a process has derived of a machine is kept for its next test.
"""

from functools import partial

import pytest

from helpers import firmware_tools, inside


@pytest.fixture(autouse=True, scope="session")
def _one_folder_of_a_kind(_shared_folders_of_c):
    """What `write_folder` makes of a mechanism with options is kept for the next test, and so is
    that its own test has passed.
    """
    module = inside.codegen_folder
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            module, "folder_files", partial(firmware_tools.kept_files, module.folder_files)
        )
        patch.setattr(
            module, "run_own_test", partial(firmware_tools.tested_once, module.run_own_test)
        )
        yield


@pytest.fixture(autouse=True, scope="session")
def _one_derivation_of_a_kind():
    """A machine's formulas, samples and programs are values: they are derived once for all options
    that are the same.
    """
    module = inside.codegen_program
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_kind", firmware_tools.KeptKinds(module._kind))
        yield
