"""A function of several items on all processors, where threads would wait for the interpreter.

`concurrent.futures` can start fresh processes only if the user's program guards its main module, and forked
ones are not safe beside threads. Here fresh interpreters import nothing of that program.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

__all__ = ["map_in_processes"]

Item = TypeVar("Item")
Result = TypeVar("Result")

#: What an interpreter does: it answers each function and item with the result or the exception.
_SERVE = """
import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
while True:
    try:
        function, item = pickle.load(sys.stdin.buffer)
    except EOFError:
        break
    try:
        answer = True, function(item)
    except Exception as error:
        answer = False, error
    pickle.dump(answer, sys.stdout.buffer)
    sys.stdout.buffer.flush()
"""


def map_in_processes(function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Yield the results in the order of the items; the first exception is raised where its result would be.

    The function is a module's, and it, items and results can be pickled. With one processor or one item all
    is done here.

    Examples
    --------
    >>> import math
    >>> list(map_in_processes(math.factorial, [3, 4, 5]))
    [6, 24, 120]
    """
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count = min(processors, len(items))
    if count < 2:
        yield from map(function, items)
        return
    processes = [_start() for _ in range(count)]
    unused = list(processes)
    own = threading.local()

    def take_process() -> None:
        own.process = unused.pop()

    def answer(item: Item) -> Result:
        own.process.stdin.write(pickle.dumps((function, item)))
        own.process.stdin.flush()
        succeeded, result = pickle.load(own.process.stdout)
        if not succeeded:
            raise result
        return result  # type: ignore[no-any-return]

    threads = ThreadPoolExecutor(count, initializer=take_process)
    try:
        yield from threads.map(answer, items)
    finally:
        for process in processes:
            process.kill()
            process.communicate()
        threads.shutdown(cancel_futures=True)


def _start() -> subprocess.Popen[bytes]:
    # One thread each: the processes themselves fill the processors.
    single = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    process = subprocess.Popen(
        [sys.executable, "-c", _SERVE],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=os.environ | single,
    )
    assert process.stdin is not None
    pickle.dump(sys.path, process.stdin)
    process.stdin.flush()
    return process
