"""Checks of arguments; each raises an error that names the thing, the rule and the value."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidParameterError

__all__ = ["require_choice", "require_finite", "require_in_range", "require_integer", "require_shape"]


def require_finite(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return `value` as a float64 array, or raise when it holds NaN or infinity.

    Parameters
    ----------
    name : str
        What the value is called in the error.
    value : array_like
        Any shape.

    Returns
    -------
    ndarray of float64
        The same shape as `value`.

    Raises
    ------
    InvalidParameterError
        If `value` is not numeric, or any element is not finite; the message gives the first such element.

    References
    ----------
    Own design.
    """
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidParameterError(f"{name} must be numeric, but is {value!r}") from error
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        where = f"[{', '.join(map(str, index))}]" if index else ""
        raise InvalidParameterError(f"{name} must be finite, but {name}{where} is {array[index]}")
    return array


def require_in_range(
    name: str, value: ArrayLike, low: float | None = None, high: float | None = None, *, unit: str = ""
) -> NDArray[np.float64]:
    """Return `value` as finite float64, or raise when an element lies outside ``[low, high]``.

    Parameters
    ----------
    name : str
        What the value is called in the error.
    value : array_like
        Any shape.
    low, high : float, optional
        Inclusive ends; None leaves that end open.
    unit : str, optional
        Unit shown in the error.

    Returns
    -------
    ndarray of float64
        The same shape as `value`.

    Raises
    ------
    InvalidParameterError
        If an element is not finite or lies outside the range.

    References
    ----------
    Own design.
    """
    array = require_finite(name, value)
    bad = np.zeros(array.shape, dtype=bool)
    if low is not None:
        bad |= array < low
    if high is not None:
        bad |= array > high
    if bad.any():
        first = array[bad].flat[0]
        suffix = f" {unit}" if unit else ""
        if high is None:
            rule = f"be at least {low:g}{suffix}"
        elif low is None:
            rule = f"be at most {high:g}{suffix}"
        else:
            rule = f"lie between {low:g} and {high:g}{suffix}"
        raise InvalidParameterError(f"{name} must {rule}, but is {first:.6g}{suffix}")
    return array


def require_integer(name: str, value: Any, low: int | None = None, high: int | None = None) -> int:
    """Return `value` as a Python int, or raise when it is no integer within ``[low, high]``.

    Parameters
    ----------
    name : str
        What the value is called in the error.
    value : int
        A Python or numpy integer; bool is refused.
    low, high : int, optional
        Inclusive ends.

    Returns
    -------
    int
        The value.

    Raises
    ------
    InvalidParameterError
        If `value` is not an integer or lies outside the range.

    References
    ----------
    Own design.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InvalidParameterError(f"{name} must be an integer, but is {value!r}")
    if (low is not None and value < low) or (high is not None and value > high):
        rule = f"be at least {low}" if high is None else f"lie between {low} and {high}"
        raise InvalidParameterError(f"{name} must {rule}, but is {value}")
    return int(value)


def require_choice(name: str, value: str, choices: tuple[str, ...]) -> str:
    """Return `value`, or raise when it is none of `choices`.

    Parameters
    ----------
    name : str
        What the value is called in the error.
    value : str
        The value.
    choices : tuple of str
        What is allowed.

    Returns
    -------
    str
        The value.

    Raises
    ------
    InvalidParameterError
        If `value` is none of `choices`.

    References
    ----------
    Own design.
    """
    if value not in choices:
        raise InvalidParameterError(f"{name} must be one of {', '.join(choices)}, but is {value!r}")
    return value


def require_shape(name: str, array: NDArray[Any], shape: tuple[int | None, ...]) -> None:
    """Raise when the shape of `array` differs from `shape`.

    Parameters
    ----------
    name : str
        What the array is called in the error.
    array : ndarray
        The array.
    shape : tuple of int or None
        The shape asked for; None stands for any length.

    Raises
    ------
    InvalidParameterError
        If the number of axes or a length differs.

    References
    ----------
    Own design.
    """
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
        raise InvalidParameterError(f"{name} must have the shape {wanted}, but has {array.shape}")
