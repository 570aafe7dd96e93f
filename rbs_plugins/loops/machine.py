"""What kind of processor this is, as far as compiled loops care, and what LLVM would not do for it by itself.

LLVM uses vectors of 256 bits on processors of Intel that have 512, and gather instructions on those of AMD, where
single loads are faster. Both are attributes of a function, which numba has no word for: a loop that wants another
choice calls one of the two intrinsics here, which leave nothing but the attribute.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from llvmlite import binding
from numba import config, types
from numba.extending import intrinsic

_config: Any = config  # its numbers are made at run time


_host_name = cache(binding.get_host_cpu_name)
_host_features = cache(lambda: binding.get_host_cpu_features().flatten())


def processor() -> str:
    """One of "intel512" (vectors of 512 bits, slow roots), "amd" and "other"; by NUMBA_CPU_NAME where that is set."""
    if _config.DISABLE_JIT:
        return "other"  # plain Python knows no processors
    name, features = _config.CPU_NAME or _host_name(), _features()
    if name.startswith("znver"):
        return "amd"
    return "intel512" if "+avx512f" in features else "other"


def _features() -> str:
    chosen = _config.CPU_FEATURES
    return _host_features() if chosen is None else str(chosen)


def _attribute(name: str, value: Any) -> Any:
    """An intrinsic that gives the function in which it is called an attribute."""

    @intrinsic
    def mark(context: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            # llvmlite knows attributes without values only, and keeps them in a set
            set.add(builder.function.attributes, f'"{name}"="{value()}"')
            return context.get_dummy_value()

        return types.none(), code

    return mark


widest = _attribute("prefer-vector-width", lambda: 512)
narrower = _attribute("prefer-vector-width", lambda: 256)
no_gathers = _attribute("target-features", lambda: f"{_features()},+prefer-no-gather")


@intrinsic
def apart(context: Any) -> Any:
    """Promises that no array argument of the function in which it is called overlaps one that the function writes.

    LLVM would else compare the addresses of all of them before a vectorised loop, and gives up if they are many.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        for argument in builder.function.args:
            kind = argument.type
            # pointers to bytes are owners of memory, not data
            if getattr(kind, "is_pointer", False) and str(getattr(kind, "pointee", "i8")) in _NUMBERS:
                argument.add_attribute("noalias")
        return context.get_dummy_value()

    return types.none(), code


_NUMBERS = ("double", "float", "i16", "i32", "i64")
