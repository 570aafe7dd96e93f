"""The text of a law: plain Python functions, with the helpers and constants they name, as source for a module.

A loop with the text of its law in a module of its own can be cached on disk; a loop closed over a function cannot.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import textwrap
import types
from collections.abc import Callable
from typing import Any

STRICT = "@njit(error_model='numpy', forceinline=True)"


def plain(function: Any) -> Callable[..., Any]:
    """The Python function behind a jitted one, or the function itself."""
    return getattr(function, "py_func", function)


def definitions(functions: dict[str, Any]) -> list[str] | None:
    """Source of functions under new names, preceded by whatever they need.

    Args:
        functions: new name -> function.

    Returns:
        Pieces of source in the order in which they must stand, or None if some piece has no source (typed into an
        interpreter, built by exec) or needs something that no text can say, such as an array.
    """
    pieces: dict[str, str] = {}
    for name, function in functions.items():
        if not _collect(name, plain(function), pieces, set()):
            return None
    return list(pieces.values())


def _collect(name: str, function: Any, pieces: dict[str, str], busy: set[int]) -> bool:
    """Adds a function and its needs to the pieces; False if that cannot be done."""
    tree = _definition(function)
    if tree is None or id(function) in busy:
        return False
    tree.name = name
    scope = {**function.__globals__, **_closure(function)}
    for needed in sorted(_free_names(tree)):
        if needed in scope:
            if not _collect_value(needed, scope[needed], pieces, busy | {id(function)}):
                return False
        elif not hasattr(builtins, needed):
            return False
    return _add(name, f"{STRICT}\n{ast.unparse(tree)}", pieces)


def _collect_value(name: str, value: Any, pieces: dict[str, str], busy: set[int]) -> bool:
    if isinstance(value, types.ModuleType):
        return _add(name, f"import {value.__name__} as {name}", pieces)
    if isinstance(value, bool | int | float):
        return _add(name, f"{name} = {value!r}", pieces)
    if isinstance(plain(value), types.FunctionType):
        return _collect(name, plain(value), pieces, busy)
    if isinstance(value, types.BuiltinFunctionType) and getattr(value, "__module__", None) == "math":
        return _add(name, f"from math import {value.__name__} as {name}", pieces)
    return False


def _add(name: str, text: str, pieces: dict[str, str]) -> bool:
    """Adds a piece; False if another piece has the name already."""
    return pieces.setdefault(name, text) == text


def _closure(function: types.FunctionType) -> dict[str, Any]:
    names, cells = function.__code__.co_freevars, function.__closure__ or ()
    return {name: cell.cell_contents for name, cell in zip(names, cells, strict=True)}


def _free_names(tree: ast.FunctionDef) -> set[str]:
    """Names that the body takes from outside."""
    used = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    own = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    return used - own - {a.arg for a in tree.args.args}


def _definition(function: Any) -> ast.FunctionDef | None:
    """The function as a bare `def`: no decorators, annotations, defaults or docstring."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return None
    if function.__name__ == "<lambda>":
        return _from_lambda(function, tree)
    found = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.name == function.__name__]
    if not found:
        return None
    bare = found[0]
    body = bare.body[1:] if ast.get_docstring(bare) is not None else bare.body
    return _bare(bare.args, body or [ast.Pass()])


def _from_lambda(function: types.FunctionType, tree: ast.AST) -> ast.FunctionDef | None:
    """The lambda of the source line that compiles to the same code; None if two of them do."""
    same = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Lambda):
            code = eval(compile(ast.Expression(node), "<law>", "eval"), {}).__code__  # noqa: S307  our own user's line
            if code.co_code == function.__code__.co_code and code.co_consts == function.__code__.co_consts:
                same.append(node)
    if len({ast.dump(node) for node in same}) != 1:
        return None
    return _bare(same[0].args, [ast.Return(same[0].body)])


def _bare(arguments: ast.arguments, body: list[ast.stmt]) -> ast.FunctionDef:
    names = [ast.arg(a.arg) for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    args = ast.arguments(posonlyargs=[], args=names, kwonlyargs=[], kw_defaults=[], defaults=[])
    return ast.fix_missing_locations(ast.FunctionDef(name="law", args=args, body=body, decorator_list=[]))
