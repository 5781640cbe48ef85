"""Functions of many items on all processors, where threads would wait for the interpreter.

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
from typing import Self, TypeVar

from telespring.rehearsal.run import thread_count

__all__ = ["Processes"]

Item = TypeVar("Item")
Result = TypeVar("Result")

#: What an interpreter does: it answers each function and item with the result or the exception. Ctrl-C
#: reaches it, too, but its end is for the program to decide that started it.
_SERVE = """
import pickle, signal, sys
signal.signal(signal.SIGINT, signal.SIG_IGN)
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


class Processes:
    """An interpreter for every processor, started where the first is needed, for one thread to use.

    Use it in a ``with`` statement, which ends the interpreters. Another thread may do that earlier, by `end`:
    then the thread that waits for results receives an `EOFError` or a `BrokenPipeError`.

    Examples
    --------
    >>> import math
    >>> with Processes() as processes:
    ...     list(processes.map(math.factorial, [3, 4, 5]))
    [6, 24, 120]
    """

    def __init__(self) -> None:
        self._started: list[subprocess.Popen[bytes]] = []
        self._lock = threading.Lock()
        self.has_ended = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
        for process in self._started:
            process.communicate()

    def end(self) -> None:
        """End all interpreters, whatever they do."""
        with self._lock:
            self.has_ended = True
            for process in self._started:
                process.kill()
        for process in self._started:
            process.wait()

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """Yield the results in the order of the items; an exception is raised where its result would be.

        The function is a module's, and it, items and results can be pickled.
        """
        unused = self._processes(min(thread_count(None), len(items)))
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

        if not items:
            return
        threads = ThreadPoolExecutor(len(unused), initializer=take_process)
        is_complete = False
        try:
            yield from threads.map(answer, items)
            is_complete = True
        finally:
            if not is_complete:
                # an answer that nobody takes would be the next question's
                self.end()
            threads.shutdown(cancel_futures=True)

    def _processes(self, count: int) -> list[subprocess.Popen[bytes]]:
        with self._lock:
            if self.has_ended:
                raise EOFError("these processes have ended")
            while len(self._started) < count:
                self._started.append(_start())
            return self._started[:count]


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
