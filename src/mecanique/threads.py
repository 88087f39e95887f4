"""Keep BLAS to one thread while the matrices of loops are small.

For those, threads cost more than they save, and on a busy machine they wait for one another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from threading import Lock
from typing import ParamSpec, TypeVar, final

P = ParamSpec("P")
T = TypeVar("T")


@final
class _Limit:
    """The limit in force; as it holds for the whole process, its users are counted."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._restore = ExitStack()

    def enter(self) -> None:
        """Limit BLAS to one thread, unless a user has done so."""
        import scipy.linalg  # noqa: F401  # a BLAS that is loaded later would not be limited
        from threadpoolctl import threadpool_limits

        with self._lock:
            if not self._users:
                self._restore.enter_context(threadpool_limits(1, user_api="blas"))
            self._users += 1

    def leave(self) -> None:
        """Restore the number of threads, unless another user needs the limit."""
        with self._lock:
            self._users -= 1
            if not self._users:
                self._restore.close()


_LIMIT = _Limit()


@contextmanager
def limit_threads() -> Iterator[None]:
    """Keep BLAS to one thread, and restore the number of threads afterwards."""
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


def one_thread_for_loops(function: Callable[P, T]) -> Callable[P, T]:
    """Keep BLAS to one thread in a function, if its first argument is a mechanism with loops."""

    @wraps(function)
    def call(*args: P.args, **options: P.kwargs) -> T:
        mechanism = args[0] if args else options.get("mechanism")
        if not getattr(mechanism, "loops", ()):
            # the function itself refuses anything but a mechanism
            return function(*args, **options)
        with limit_threads():
            return function(*args, **options)

    return call
