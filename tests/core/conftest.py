"""The oracle of the colour tests."""

from __future__ import annotations

import sys
import warnings
from types import ModuleType
from unittest.mock import NonCallableMock

import pytest
from hypothesis import settings

# Speed is not asserted by the clock: a test machine that is busy with other things is no error of a reader.
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")


@pytest.fixture(scope="session")
def colour() -> ModuleType:
    """colour-science, imported without its side effects.

    On import it warns about each optional library that is absent, and puts mocks of scipy and matplotlib into
    sys.modules in their place; other tests, which check what has been imported, must not see those.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour as module
    for name in [name for name, loaded in sys.modules.items() if isinstance(loaded, NonCallableMock)]:
        del sys.modules[name]
    return module
