"""The tables shipped with the package: one compressed file per subject, read once, handed out read-only.

Where each table comes from and under which terms is told by the JSON file of the same name beside it.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .errors import InvalidParameterError

__all__ = ["table", "table_names"]

_FOLDER = Path(__file__).parent / "data"


@lru_cache(maxsize=1)
def _archives() -> dict[str, NDArray[np.float64]]:
    arrays: dict[str, NDArray[np.float64]] = {}
    for path in sorted(_FOLDER.glob("*.npz")):
        with np.load(path, allow_pickle=False) as archive:
            for key in archive.files:
                array = archive[key].astype(np.float64)
                array.flags.writeable = False
                arrays[key] = array
    return arrays


def table(name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fetch a table by its name.

    Parameters
    ----------
    name : str
        ``group/name``, one of :func:`table_names`, such as ``"illuminant/FL2"``.

    Returns
    -------
    wavelengths_nm : ndarray (W,)
        Wavelengths in nm, strictly increasing.
    values : ndarray (..., W)
        Values; several curves over the same wavelengths stand on the first axis.

    Raises
    ------
    InvalidParameterError
        If there is no such table.

    References
    ----------
    Own design; the sources are in the JSON files beside the data.
    """
    arrays = _archives()
    if name not in arrays:
        group = name.partition("/")[0]
        known = ", ".join(n.partition("/")[2] for n in table_names(group)) or "nothing"
        raise InvalidParameterError(f"table must be one of group {group!r} ({known}), but is {name!r}")
    stored = arrays[name]
    wavelengths = stored[0]
    values = stored[1] if stored.shape[0] == 2 else stored[1:]
    return wavelengths, values


def table_names(group: str) -> tuple[str, ...]:
    """List the tables of a group.

    Parameters
    ----------
    group : str
        The part before the slash, such as ``"illuminant"``.

    Returns
    -------
    tuple of str
        Full names, in the order in which they are stored.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    return tuple(name for name in _archives() if name.startswith(group + "/"))
