"""Processes that a render from the command line is spread over."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

from ._core import core

__all__ = ["process_pool"]

# Each process has a processor to itself; were its linear algebra spread over all of them, they would only wait.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def process_pool(count: int) -> Iterator[Executor | None]:
    """Start `count` processes for a render; None, for threads, when `count` is 0.

    Raises
    ------
    DichromaticError
        If `count` is negative, or other processes could not find the core because it runs inside an extension.
    """
    if count < 0:
        raise core.InvalidParameterError(f"processes must be at least 0, but is {count}")
    if count == 0:
        yield None
        return
    if core.__name__ != "spectral_core":
        raise core.DichromaticError(
            "--processes needs the package installed with pip: processes that an extension starts do not find it; "
            "leave it out, and threads are used"
        )
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        # Not forked: Blender has threads of its own, which a copy of the process would lack.
        with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
            yield pool
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
