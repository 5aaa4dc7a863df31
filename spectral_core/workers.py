"""Who works the tasks of a render off: the caller itself, threads, or whatever an Executor stands for.

Results come back in the order of the tasks, so that nothing depends on who was faster.
"""

from __future__ import annotations

import itertools
import os
import pickle
import threading
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor, wait
from dataclasses import replace

from .errors import RenderCancelledError
from .job import Job, Task, TaskResult
from .scene import RenderSettings, Scene

__all__ = ["remote_results", "results", "run_remote", "stopper", "thread_count"]

_POLL_S = 0.03  # between two looks at whether the caller wants an end
_IN_FLIGHT = 2  # tasks handed out for each worker: enough to keep it busy, few enough to end soon

_remote_lock = threading.Lock()
_remote_job: tuple[str, Job] | None = None


def thread_count(settings: RenderSettings) -> int:
    """How many threads a render uses.

    Parameters
    ----------
    settings : RenderSettings
        Its number of threads, or 0.

    Returns
    -------
    int
        That number; for 0 one for each processor that this program may use.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    if settings.threads:
        return settings.threads
    allowed = getattr(os, "sched_getaffinity", None)
    return max(1, len(allowed(0)) if allowed is not None else os.cpu_count() or 1)


def results(job: Job, tasks: list[Task], workers: int, is_cancelled: Callable[[], bool]) -> Iterator[TaskResult]:
    """Work tasks off in this process.

    Parameters
    ----------
    job : Job
        The render.
    tasks : list of Task
        Its tasks.
    workers : int
        Threads; with 1 the caller's own is used.
    is_cancelled : callable
        Asked in the caller's thread, every few hundredths of a second.

    Yields
    ------
    TaskResult
        In the order of the tasks.

    Raises
    ------
    RenderCancelledError
        If `is_cancelled` said so; all threads have ended by then.

    References
    ----------
    Own design.
    """
    if workers == 1 or len(tasks) == 1:
        for task in tasks:
            yield job.run(task, stopper(is_cancelled))
        return
    ended = threading.Event()
    with ThreadPoolExecutor(workers, thread_name_prefix="dichromatic") as pool:
        try:
            yield from _in_order(
                (pool.submit(job.run, task, stopper(ended.is_set)) for task in tasks),
                workers,
                is_cancelled,
            )
        finally:
            ended.set()  # a thread that is still at work stops at its next look


def remote_results(
    executor: Executor,
    scene: Scene,
    settings: RenderSettings,
    rows: int | None,
    tasks: list[Task],
    is_cancelled: Callable[[], bool],
) -> Iterator[TaskResult]:
    """Work tasks off wherever an executor has them worked off.

    Each worker prepares the render for itself, once: what is sent is the scene, the settings and a task.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Of threads, processes or machines that have this package.
    scene, settings, rows
        The render, as for :func:`~spectral_core.renderer.render`.
    tasks : list of Task
        Its tasks.
    is_cancelled : callable
        Asked every few hundredths of a second.

    Yields
    ------
    TaskResult
        In the order of the tasks.

    Raises
    ------
    RenderCancelledError
        If `is_cancelled` said so; tasks that have begun run to their end unseen.

    References
    ----------
    PEP 3148, futures.
    """
    key = uuid.uuid4().hex
    # A worker uses one thread: there are as many workers as there is work for.
    description = pickle.dumps((scene, replace(settings, threads=1), rows), pickle.HIGHEST_PROTOCOL)
    workers = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
    yield from _in_order((executor.submit(run_remote, key, description, task) for task in tasks), workers, is_cancelled)


def run_remote(key: str, description: bytes, task: Task) -> TaskResult:
    """Work a task off in another process; what an executor calls.

    Parameters
    ----------
    key : str
        Names the render.
    description : bytes
        Scene, settings and rows.
    task : Task
        The task.

    Returns
    -------
    TaskResult
        What was found.

    Raises
    ------
    DichromaticError
        As :meth:`Job.run`.

    References
    ----------
    Own design.
    """
    global _remote_job
    with _remote_lock:
        if _remote_job is None or _remote_job[0] != key:
            scene, settings, rows = pickle.loads(description)
            _remote_job = key, Job.prepare(scene, settings, rows)
        job = _remote_job[1]
    return job.run(task)


def _in_order(
    futures: Iterator[Future[TaskResult]], workers: int, is_cancelled: Callable[[], bool]
) -> Iterator[TaskResult]:
    """Hand tasks out as workers come free, and give their results back in order."""
    under_way: list[Future[TaskResult]] = []
    stop_if_cancelled = stopper(is_cancelled)
    try:
        under_way += itertools.islice(futures, workers * _IN_FLIGHT)
        while under_way:
            while not under_way[0].done():
                stop_if_cancelled()
                wait(under_way[:1], timeout=_POLL_S)
            stop_if_cancelled()
            yield under_way.pop(0).result()
            busy = sum(not future.done() for future in under_way)
            under_way += itertools.islice(futures, max(workers * _IN_FLIGHT - busy, 0))
    finally:
        for future in under_way:
            future.cancel()


def stopper(is_cancelled: Callable[[], bool]) -> Callable[[], None]:
    """Make a function that ends the work when the caller wants an end.

    Parameters
    ----------
    is_cancelled : callable
        Whether the caller does.

    Returns
    -------
    callable
        Raises RenderCancelledError if so.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """

    def stop_if_cancelled() -> None:
        if is_cancelled():
            raise RenderCancelledError("the render was cancelled")

    return stop_if_cancelled
