"""One thread of linear algebra: faster for matrices of this size, and the same on each machine."""

from collections.abc import Callable
from functools import cache, wraps
from importlib import import_module
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


@cache
def _blas_libraries() -> ThreadpoolController:
    """The BLAS libraries of NumPy and SciPy; they are searched once, because that takes 10 ms."""
    # the library of SciPy is loaded with this module
    import_module("scipy.linalg")
    return ThreadpoolController().select(user_api="blas")


def with_one_blas_thread(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """The function, run with one BLAS thread.

    Two threads in each of two processes made a fit 60 times slower, and the number of threads
    changes the last digits of a result.
    """

    @wraps(function)
    def run_with_one_thread(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        with _blas_libraries().limit(limits=1):
            return function(*args, **kwargs)

    return run_with_one_thread
