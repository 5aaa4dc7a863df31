"""Which optional packages are really installed.

colour-science puts a mock into ``sys.modules`` for packages that it misses, so neither an import nor
``pytest.importorskip`` tells; the installed distributions do.
"""

from importlib import metadata

import pytest

__all__ = ["needs_matplotlib"]


def _is_installed(package: str) -> bool:
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True


needs_matplotlib = pytest.mark.skipif(not _is_installed("matplotlib"), reason="matplotlib is not installed")
