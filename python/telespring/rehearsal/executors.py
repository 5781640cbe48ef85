"""Tasks on whatever runs them: threads of this process, or any executor with ``submit``."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from typing import Any, Protocol, TypeVar, TypeVarTuple

from telespring._errors import InvalidInput

__all__ = ["Executor", "refuse_workers", "run_tasks", "tasks_in_flight"]

#: Tasks that an executor of unknown size is given at a time: enough for a cluster, few enough for the memory.
_IN_FLIGHT = 512
#: Seconds between two looks at futures that cannot be waited for.
_PATIENCE = 0.05

Result = TypeVar("Result")
Arguments = TypeVarTuple("Arguments")


class Executor(Protocol):
    """What runs tasks: `concurrent.futures`, loky, ``dask.distributed.Client.get_executor()`` and others.

    The future that ``submit`` returns has ``done``, ``result`` and, if possible, ``cancel``.
    """

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Any:
        """Start a call somewhere, and return its future."""


def refuse_workers(executor: Executor | None, workers: int | None) -> None:
    """Refuse a number of workers beside an executor, which has its own."""
    if executor is not None and workers is not None:
        raise InvalidInput(
            "workers", str(workers), "an executor has its own workers", "Leave out workers or executor."
        )


def tasks_in_flight(executor: Executor) -> int:
    """Return how many tasks an executor is given at a time."""
    workers = getattr(executor, "_max_workers", None)  # that of concurrent.futures and loky
    return 4 * workers if isinstance(workers, int) and workers > 0 else _IN_FLIGHT


def run_tasks(
    executor: Executor,
    function: Callable[[*Arguments], Result],
    tasks: Iterable[tuple[*Arguments]],
    in_flight: int,
) -> Generator[Result]:
    """Call a function with the arguments of each task, and yield each result when it is there.

    Closing the generator, or an error of a task, cancels what has not begun. The executor is not shut down.
    """
    waiting = iter(tasks)
    running: set[Any] = set()
    try:
        while True:
            # No more, because results that nobody has taken yet need memory.
            while len(running) < in_flight and (task := next(waiting, None)) is not None:
                running.add(executor.submit(function, *task))
            if not running:
                return
            ended = _wait_for_some(running)
            running -= ended
            # An error waits until what ended with it has been taken.
            failed = None
            for future in ended:
                try:
                    result = future.result()
                except Exception as error:
                    failed = failed or error
                else:
                    yield result
            if failed is not None:
                raise failed
    except (BrokenExecutor, CancelledError) as lost:
        raise InvalidInput(
            "executor",
            type(executor).__name__,
            f"its workers must live until the work is done, but they stopped ({type(lost).__name__})",
            "Finished trials are kept: call again with a new executor to resume.",
        ) from lost
    finally:
        for future in running:
            cancel = getattr(future, "cancel", None)
            if cancel is not None:
                cancel()


def _wait_for_some(running: set[Any]) -> set[Any]:
    """Wait until at least one of these futures is done, and return those that are."""
    if all(isinstance(future, Future) for future in running):
        return set(wait(running, return_when=FIRST_COMPLETED).done)
    while not (ended := {future for future in running if future.done()}):
        time.sleep(_PATIENCE)
    return ended
