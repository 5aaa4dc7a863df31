"""Arrays of vectors (N, 3) that hold one component after the other in memory.

numpy runs its inner loops along the last axis of an array in C order: with three elements a loop it is ten times slower
than on whole columns. Arrays in Fortran order have the same shape and meaning, and arithmetic keeps their order.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["dot_rows", "take_rows"]

Array = NDArray[Any]


def dot_rows(first: Array, second: Array) -> Array:
    """Scalar products of vectors.

    Neither einsum nor a matrix product, which add in another order where there is one vector or where the array is in C
    order: what a ray finds must not depend on how many go with it.

    Parameters
    ----------
    first : (N, 3) ndarray
        Vectors.
    second : (N, 3) or (3,) ndarray
        Vectors, or one for all.

    Returns
    -------
    (N,) ndarray
        Their products.

    Raises
    ------
    ValueError
        By numpy, if the numbers of vectors differ.

    References
    ----------
    Own design.
    """
    second = np.atleast_2d(second)  # numpy 1 would not count the type of a single number
    total = first[:, 0] * second[:, 0]
    total += first[:, 1] * second[:, 1]
    total += first[:, 2] * second[:, 2]
    return np.asarray(total)


def take_rows(vectors: Array, index: NDArray[np.integer[Any]]) -> Array:
    """Pick vectors by their numbers.

    Parameters
    ----------
    vectors : (M, K) ndarray
        Vectors in any order in memory.
    index : (N,) ndarray of int
        Which of them, 0 to M - 1.

    Returns
    -------
    (N, K) ndarray
        ``vectors[index]`` in Fortran order.

    Raises
    ------
    IndexError
        If a number is out of range.

    References
    ----------
    Own design.
    """
    if vectors.flags.c_contiguous:
        return np.asfortranarray(vectors.take(index, axis=0))
    if vectors.strides[0] == 0:  # one vector for all, as the direction of a sun
        return np.broadcast_to(vectors[0], (len(index), vectors.shape[1]))
    taken = np.empty((vectors.shape[1], len(index)), vectors.dtype)
    if len(index) and (index.min() < 0 or index.max() >= len(vectors)):
        raise IndexError(f"rows must be 0 to {len(vectors) - 1}, but one is not")
    for source, column in zip(vectors.T, taken, strict=True):
        source.take(index, out=column, mode="clip")  # checked above: numpy would buffer its output to check
    return taken.T
