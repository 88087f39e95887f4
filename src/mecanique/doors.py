"""Explain failed calls of public functions and methods by arguments of a wrong kind.

Nothing is checked before a call: only where one fails by accident, with an exception that is no
`MecaniqueError`, are its arguments compared with the annotations of the function. The methods of a
class are explained once it is asked for by its public name, or an object of it is returned.
"""

from __future__ import annotations

import builtins
import collections.abc
import math
import operator
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

_CALLED: dict[Any, str] = {
    str: "a text",
    int: "a whole number",
    float: "a number",
    bool: "True or False",
    os.PathLike: "a path",
    "ndarray": "an array",
    NoneType: "None",
}
"""What arguments of some types are called."""


_EXPLAINED: set[type] = set()
"""Classes whose methods are explained, and those of others, which stay as they are."""


def explain(member: Any, home: str) -> Any:
    """Return a public function, or a class, that refuses arguments of a wrong kind in words."""
    if isinstance(member, FunctionType):
        explained = _explain(member)
        explained.__module__ = home  # what is pickled by name is found there
        return explained
    if isinstance(member, type):
        if isinstance(member.__init__, FunctionType):  # type: ignore[misc]
            member.__init__ = _explain(member.__init__)  # type: ignore[misc]
        _explain_methods(member)
    return member


def _explain_methods(member: type) -> None:
    """Replace the public methods of one of our classes, and of those it inherits from."""
    for base in member.__mro__:
        if base in _EXPLAINED:
            continue
        _EXPLAINED.add(base)
        if base.__module__.partition(".")[0] != __package__:
            continue
        for name, method in list(vars(base).items()):
            if name.startswith("_"):
                continue
            if isinstance(method, FunctionType):
                setattr(base, name, _explain(method))
            elif isinstance(method, (classmethod, staticmethod)):
                setattr(base, name, type(method)(_explain(method.__func__)))


def _explain(function: Callable[..., Any]) -> Any:
    @wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        try:
            answer = function(*args, **named)
        except MecaniqueError:
            raise
        except Exception as error:
            fault = _find_fault(function, args, named)
            if fault:
                raise InputError(fault) from error
            raise
        if type(answer) not in _EXPLAINED:
            _explain_methods(type(answer))
        return answer

    return call


def _find_fault(function: Callable[..., Any], args: tuple[Any, ...], named: dict[str, Any]) -> str:
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
        if name == "np":
            return sys.modules["numpy"]
        for home in (builtins, collections.abc, typing, sys.modules[__package__]):
            if hasattr(home, name):
                return getattr(home, name)
        return Any


def _read_hint(annotation: Any, function: Any) -> Any:
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
        return any(type(value) is type(choice) and value == choice for choice in inner)
    if origin is not None:
        if isinstance(value, (str, bytes)) or not isinstance(origin, type):
            return not isinstance(origin, type)
        return isinstance(value, origin) and _suit_within(value, origin, inner)
    if hint in (float, int):
        return not isinstance(value, bool) and _is_number(value, whole=hint is int)
    return not isinstance(hint, type) or isinstance(value, hint)


def _is_number(value: Any, *, whole: bool) -> bool:
    """Return whether a value can be had as a float, or as an integer of the machine."""
    try:
        if whole:
            return abs(operator.index(value)) <= sys.maxsize
        return not math.isnan(float(value)) and not isinstance(value, str)
    except (TypeError, ValueError, OverflowError):
        return False


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
    kind = origin or hint
    name = getattr(kind, "__name__", str(kind))
    if name in _CALLED:  # what is not imported here
        return _CALLED[name]
    if isinstance(origin, type) and issubclass(origin, Iterable):
        return f"several, each {_say(inner[0])}" if inner and inner[0] is not Any else "several"
    return _CALLED.get(kind, f"{'an' if name[:1] in 'AEIO' else 'a'} {name}")


def _shorten(value: Any) -> str:
    """Return a wrong argument and its type."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if isinstance(value, int) and abs(value) > sys.maxsize:
        return f"an integer of {math.ceil(value.bit_length() * math.log10(2))} digits"
    text = repr(value)
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
    return text if value is None else f"{text}, of type {type(value).__name__}"
