"""Files that appear whole or not at all: written to a temporary name in the same folder, then moved into place."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import DichromaticError

__all__ = ["replacing"]


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary file to write, and move it to `path` when the block ends without an error.

    Parameters
    ----------
    path : path-like
        Where the file shall stand; what stands there stays untouched until then.

    Returns
    -------
    context manager of Path
        An empty file beside `path` with the same suffix.

    Raises
    ------
    DichromaticError
        If the folder does not exist or the file cannot be written; the temporary file is removed.

    References
    ----------
    Own design; renaming within a folder is atomic (POSIX rename, Windows MoveFileEx).
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise DichromaticError(f"{target} cannot be written: the folder {target.parent} does not exist")
    try:
        handle, name = tempfile.mkstemp(suffix=target.suffix, prefix=f".{target.stem}-", dir=target.parent)
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            umask = os.umask(0)
            os.umask(umask)
            temporary.chmod(0o666 & ~umask)  # mkstemp makes private files
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise DichromaticError(f"{target} cannot be written: {error}") from error
