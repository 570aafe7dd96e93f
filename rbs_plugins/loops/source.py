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
from functools import lru_cache
from typing import Any

import numpy as np

# A function that does not refuse the liberties of its caller is compiled with them: pulls of a bond would then differ
# by a rounding between its ends, and a criterion might break one direction alone. None is called from Python.
STRICTLY: dict[str, Any] = {"error_model": "numpy", "forceinline": True, "fastmath": False}
STRICTLY |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
STRICT = f"@njit({', '.join(f'{name}={value!r}' for name, value in STRICTLY.items())})"
# Before every name that a law takes from outside: a helper of the user must not replace a function of the loops.
OWN = "own_"
FUNCTIONS = "rbs_plugins.functions"
NUMBERS = (bool, int, float, np.bool_, np.integer, np.floating)


def plain(function: Any) -> Callable[..., Any]:
    """The Python function behind a jitted one, or the function itself."""
    return getattr(function, "py_func", function)


def compilable(function: Any, *, busy: tuple[Any, ...] = ()) -> Callable[..., Any]:
    """The same function, with the plain functions that it names jitted: numba calls no others."""
    from numba import njit

    original = plain(function)
    if not isinstance(original, types.FunctionType):
        return function
    helpers = {}
    for name in original.__code__.co_names:
        value = original.__globals__.get(name)
        ours = getattr(value, "__module__", None) == FUNCTIONS
        if isinstance(value, types.FunctionType) and not ours and value not in (*busy, original):
            inner = compilable(value, busy=(*busy, original))
            helpers[name] = njit(**STRICTLY)(inner)
    if not helpers:
        return original
    scope = {**original.__globals__, **helpers}
    return types.FunctionType(original.__code__, scope, original.__name__, original.__defaults__, original.__closure__)


@lru_cache(maxsize=1000)
def answers(function: Any) -> bool:
    """False if some branch of a function ends without returning a value; True also where there is no source."""
    tree = _definition(plain(function))
    return tree is None or _returns(tree.body)


def _returns(body: list[ast.stmt]) -> bool:
    end = body[-1]
    if isinstance(end, ast.If):
        return bool(end.orelse) and _returns(end.body) and _returns(end.orelse)
    return isinstance(end, ast.Raise | ast.While | ast.For) or (isinstance(end, ast.Return) and end.value is not None)


def definitions(functions: dict[str, Any], *, single: bool = False) -> list[str] | None:
    """Source of functions under new names, preceded by whatever they need.

    Args:
        functions: new name -> function.
        single: write numbers as REAL(number), so that single precision is not widened by them; the module must say
            what REAL is.

    Returns:
        Pieces of source in the order in which they must stand, or None if some piece has no source (typed into an
        interpreter, built by exec) or needs something that no text can say, such as an array.
    """
    pieces: dict[str, str] = {}
    for name, function in functions.items():
        if not _collect(name, plain(function), pieces, set()):
            return None
    return [_narrowed(text) for text in pieces.values()] if single else list(pieces.values())


class _Narrow(ast.NodeTransformer):
    """Writes numbers as REAL(number), but for whole exponents and indices."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        node.left = self.visit(node.left)
        whole = isinstance(node.right, ast.Constant) and isinstance(node.right.value, int)
        if not (isinstance(node.op, ast.Pow) and whole):
            node.right = self.visit(node.right)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        node.value = self.visit(node.value)
        return node

    def visit_For(self, node: ast.For) -> ast.AST:
        node.body = [self.visit(each) for each in node.body]
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, bool) or not isinstance(node.value, int | float):
            return node
        return ast.Call(ast.Name("REAL", ast.Load()), [node], [])


def _narrowed(text: str) -> str:
    """A piece with its numbers in single precision."""
    head, body = text.split("\n", 1) if text.startswith("@") else ("", text)
    narrow = ast.unparse(ast.fix_missing_locations(_Narrow().visit(ast.parse(body))))
    return f"{head}\n{narrow}" if head else narrow


def _collect(name: str, function: Any, pieces: dict[str, str], busy: set[int]) -> bool:
    """Adds a function and its needs to the pieces; False if that cannot be done."""
    tree = _definition(function)
    if tree is None or id(function) in busy:
        return False
    if name.startswith(OWN) and not _add_defaults(tree, function):
        return False
    tree.name = name
    scope = names_from_outside(function)
    outer = _free_names(tree)
    for needed in sorted(outer):
        if needed in scope:
            if not _collect_value(OWN + needed, scope[needed], pieces, busy | {id(function)}):
                return False
        elif not hasattr(builtins, needed):
            return False
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in outer & scope.keys():
            node.id = OWN + node.id
    return _add(name, f"{STRICT}\n{ast.unparse(tree)}", pieces)


def _collect_value(name: str, value: Any, pieces: dict[str, str], busy: set[int]) -> bool:
    if isinstance(value, types.ModuleType):
        return _add(name, f"import {value.__name__} as {name}", pieces)
    if isinstance(value, NUMBERS):
        return _add(name, f"{name} = {_literal(value)}", pieces)
    if getattr(value, "__module__", None) == FUNCTIONS:  # compiled code knows what to take in their place
        return _add(name, f"from {FUNCTIONS} import {value.__name__} as {name}", pieces)
    if isinstance(plain(value), types.FunctionType):
        return _collect(name, plain(value), pieces, busy)
    if isinstance(value, types.BuiltinFunctionType) and getattr(value, "__module__", None) == "math":
        return _add(name, f"from math import {value.__name__} as {name}", pieces)
    return False


def _literal(value: Any) -> str:
    """A number as text that gives it back; what numpy and infinity print would not."""
    if isinstance(value, bool | np.bool_):
        return repr(bool(value))
    if isinstance(value, int | np.integer):
        return repr(int(value))
    return repr(float(value)) if np.isfinite(value) else f"float('{float(value)}')"


def _add(name: str, text: str, pieces: dict[str, str]) -> bool:
    """Adds a piece; False if another piece has the name already."""
    return pieces.setdefault(name, text) == text


def names_from_outside(function: types.FunctionType) -> dict[str, Any]:
    """What the names mean that a function does not define itself."""
    names, cells = function.__code__.co_freevars, function.__closure__ or ()
    return {**function.__globals__, **{name: cell.cell_contents for name, cell in zip(names, cells, strict=True)}}


def _free_names(tree: ast.FunctionDef) -> set[str]:
    """Names that the body takes from outside."""
    used = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    own = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    inner = {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)}
    return used - own - inner - {n.arg for n in ast.walk(tree) if isinstance(n, ast.arg)}


def _add_defaults(tree: ast.FunctionDef, function: types.FunctionType) -> bool:
    """Gives a helper its default values (those of a law are parameters); False if no text can say them."""
    given = [p.default for p in inspect.signature(function).parameters.values()]
    first = next((i for i, value in enumerate(given) if value is not inspect.Parameter.empty), len(given))
    if not all(isinstance(value, NUMBERS) for value in given[first:]):
        return False
    tree.args.defaults = [ast.parse(_literal(value), mode="eval").body for value in given[first:]]
    return True


def _definition(function: Any) -> ast.FunctionDef | None:
    """The function as a bare `def`: no decorators, annotations, defaults or docstring.

    It is looked for by its code, not by its name: what a decorator returns calls itself what it wraps.
    """
    code = getattr(function, "__code__", None)
    if code is None:
        return None
    name = code.co_name
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(code)))
    except (OSError, TypeError, SyntaxError):
        return None
    if name == "<lambda>":
        return _from_lambda(function, tree)
    found = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.name == name]
    if not found or found[0].args.vararg or found[0].args.kwarg:
        return None
    bare = found[0]
    body = bare.body[1:] if ast.get_docstring(bare) is not None else bare.body
    return _bare(bare.args, body or [ast.Pass()])


def _from_lambda(function: types.FunctionType, tree: ast.AST) -> ast.FunctionDef | None:
    """The lambda of the source line that compiles to the same code; None if two of them do."""
    same = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Lambda):
            bare = ast.fix_missing_locations(ast.Expression(ast.Lambda(_names(node.args), node.body)))
            code = eval(compile(bare, "<law>", "eval"), {}).__code__  # our own user's line
            if code.co_code == function.__code__.co_code and code.co_consts == function.__code__.co_consts:
                same.append(node)
    if len({ast.dump(node) for node in same}) != 1:
        return None
    return _bare(same[0].args, [ast.Return(same[0].body)])


def _bare(arguments: ast.arguments, body: list[ast.stmt]) -> ast.FunctionDef:
    tree = ast.FunctionDef(name="law", args=_names(arguments), body=body, decorator_list=[])
    return ast.fix_missing_locations(tree)


def _names(arguments: ast.arguments) -> ast.arguments:
    """The same argument names, and nothing but names."""
    names = [ast.arg(a.arg) for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    return ast.arguments(posonlyargs=[], args=names, kwonlyargs=[], kw_defaults=[], defaults=[])
