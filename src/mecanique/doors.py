"""Explain failed calls of public functions and classes by arguments of a wrong kind.

Nothing is checked before a call: only where one fails by accident, with an exception that is no
`MecaniqueError`, are its arguments compared with the annotations of the function.
"""

from __future__ import annotations

import builtins
import collections.abc
import os
import sys
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import wraps
from types import FunctionType, NoneType, UnionType
from typing import Any, Literal, get_args, get_origin

from mecanique.errors import InputError, MecaniqueError

_LONGEST = 60
"""Longest text of a wrong argument in a message."""

_CALLED = {
    str: "a text",
    int: "a whole number",
    float: "a number",
    bool: "True or False",
    os.PathLike: "a path",
    NoneType: "None",
}
"""What arguments of some types are called."""


def explain(member: Any, home: str) -> Any:
    """Return a public function, or a class, that refuses arguments of a wrong kind in words.

    Args:
        member: the function or class; of a class, the constructor is replaced.
        home: the package in which users find it.
    """
    if isinstance(member, FunctionType):
        explained = _explain(member)
        explained.__module__ = home  # what is pickled by name is found there
        return explained
    if isinstance(member, type) and isinstance(member.__init__, FunctionType):  # type: ignore[misc]
        member.__init__ = _explain(member.__init__)  # type: ignore[misc]
    return member


def _explain(function: FunctionType) -> Any:
    @wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        try:
            return function(*args, **named)
        except MecaniqueError:
            raise
        except Exception as error:
            fault = _find_fault(function, args, named)
            if fault:
                raise InputError(fault) from error
            raise

    return call


def _find_fault(function: FunctionType, args: tuple[Any, ...], named: dict[str, Any]) -> str:
    """Return which argument is of a wrong kind; empty if each may be right."""
    import inspect

    signature = inspect.signature(function)
    try:
        given = signature.bind(*args, **named).arguments
    except TypeError:  # a wrong number of arguments, or an unknown name
        return ""
    for name, value in given.items():
        parameter = signature.parameters[name]
        hint = _read_hint(parameter.annotation, function)
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if not _suits(value, hint):
            return f"expected {_say(hint)} for {name!r}, got {_shorten(value)}"
    return ""


class _Names(dict[str, Any]):
    """Names of an annotation; those that are imported for checks of types alone are public."""

    def __missing__(self, name: str) -> Any:
        for home in (builtins, collections.abc, typing, sys.modules[__package__]):
            if hasattr(home, name):
                return getattr(home, name)
        return Any


def _read_hint(annotation: Any, function: FunctionType) -> Any:
    if not isinstance(annotation, str):
        return Any
    try:
        return eval(annotation, {}, _Names(function.__globals__))
    except (NameError, TypeError):
        return Any


def _suits(value: Any, hint: Any) -> bool:
    """Return whether a value may be of an annotated type; numbers may be numpy's."""
    origin, inner = get_origin(hint), get_args(hint)
    if isinstance(hint, typing.ForwardRef):
        hint = hint.__forward_arg__
    if hint is Any or isinstance(hint, (str, typing.TypeVar)):
        return True
    if origin in (typing.Union, UnionType):
        return any(_suits(value, kind) for kind in inner)
    if origin is Literal:
        return isinstance(value, Collection) or value in inner
    if origin is not None:
        if isinstance(value, (str, bytes)) or not isinstance(origin, type):
            return not isinstance(origin, type)
        return isinstance(value, origin) and _suit_within(value, origin, inner)
    if hint in (float, int):
        return hasattr(value, "__float__") and not isinstance(value, bool)
    return not isinstance(hint, type) or isinstance(value, hint)


def _suit_within(value: Any, origin: type, inner: tuple[Any, ...]) -> bool:
    """Return whether what a collection contains may be of the annotated types."""
    if issubclass(origin, Mapping) and inner:
        return all(_suits(key, inner[0]) for key in value)
    if not issubclass(origin, Iterable) or not isinstance(value, Collection) or not inner:
        return True
    if origin is tuple and inner[-1] is not ...:
        return len(value) == len(inner)
    return all(_suits(entry, inner[0]) for entry in value)


def _say(hint: Any) -> str:
    """Return what a type is called, e.g. "a Motion or a Mechanism"."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (typing.Union, UnionType):
        return " or ".join(dict.fromkeys(map(_say, inner)))
    if origin is Literal:
        return " or ".join(map(repr, inner))
    if origin is Callable or hint is Callable:
        return "a function"
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return "a dictionary"
    if isinstance(origin, type) and issubclass(origin, Iterable):
        return f"several, each {_say(inner[0])}" if inner and inner[0] is not Any else "several"
    kind = origin or hint
    name = getattr(kind, "__name__", str(kind))
    return _CALLED.get(kind, f"{'an' if name[:1] in 'AEIO' else 'a'} {name}")


def _shorten(value: Any) -> str:
    """Return a wrong argument and its type."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    text = repr(value)
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
    return text if value is None else f"{text}, of type {type(value).__name__}"
