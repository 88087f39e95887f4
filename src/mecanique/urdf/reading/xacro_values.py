"""The numbers that a xacro file gives names: its arguments and its properties.

Both are noted while the library expands the file, so that included files count, and a property that
is computed from others has the value that the library computes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, final

from mecanique.errors import InputError, UnknownNameError

Letters = Mapping[str, float]
"""Values of arguments and properties instead of those written, by name."""


@final
class Values:
    """The arguments and properties of a xacro file, noted while it is expanded.

    Args:
        given: values of arguments, by name.
        letters: values of arguments and properties, instead of those given and written.
    """

    def __init__(self, given: Mapping[str, str], letters: Letters) -> None:
        self._given = frozenset(given)
        self._letters = letters
        texts = {name: repr(value) for name, value in letters.items()}
        self.arguments = _Asked({**given, **texts})
        self._tables: list[tuple[str, Any]] = []
        self._written: dict[tuple[int, str], str] = {}
        self._redefined: set[str] = set()

    def define(self, element: Any, table: Any, define: Callable[[Any, Any], None]) -> None:
        """Define a property, with another value if it is a letter.

        Args:
            element: the <xacro:property>.
            table: the library's properties at that place, by name.
            define: the library's own function, which takes both.
        """
        name = element.getAttribute("name")
        if name in self._letters and not element.hasAttribute("remove"):
            if element.hasAttribute("default"):
                element.removeAttribute("default")
            element.setAttribute("value", repr(self._letters[name]))
        # as it is written: to compute it already would fix what it is computed from
        text = element.getAttribute("value")
        if self._written.setdefault((id(table), name), text) != text:
            self._redefined.add(name)
        define(element, table)
        self._tables.append((name, table))

    def refuse_unknown(self) -> None:
        """Refuse an argument that the expanded file never asked for.

        Raises:
            UnknownNameError: naming it.
        """
        for name in sorted(self._given - self.arguments.asked):
            raise UnknownNameError("argument", name, sorted(self.arguments.asked))

    def numbers(self) -> dict[str, float | str]:
        """Return the number of each name, or in words why it has none.

        An argument and a property of one name are one letter if they have one value.
        """
        texts: dict[str, list[object]] = {name: [text] for name, text in self.arguments.items()}
        if self._tables:  # noted by the library, which a plain URDF does without
            from xacro import substitution_args_context

            substitution_args_context["arg"] = self.arguments
            for name, table in self._tables:
                try:
                    value = table[name]
                except Exception:
                    continue  # a block, or what can be computed inside of a macro only
                texts.setdefault(name, []).append(value)
            substitution_args_context["arg"] = {}
        numbers = {name: _number(values) for name, values in texts.items()}
        return numbers | dict.fromkeys(self._redefined, "is defined more than once")

    def choose(self, wanted: Collection[str]) -> tuple[dict[str, float], list[str]]:
        """Return the values of those names that are the file's, and all that can be letters.

        Args:
            wanted: names of arguments, properties, or other things.

        Raises:
            InputError: if an argument or property is no number, or more than one.
        """
        found = self.numbers()
        for name in sorted(wanted):
            if isinstance(why := found.get(name), str):
                raise InputError(f"{name!r} of the xacro file cannot be a letter: it {why}")
        numbers = {name: value for name, value in found.items() if isinstance(value, float)}
        return {name: numbers[name] for name in sorted(wanted & numbers.keys())}, sorted(numbers)


@final
class _Asked(dict[str, str]):
    """Arguments by name, to which the library adds defaults, and the names it asked for."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def _number(values: Collection[object]) -> float | str:
    """Return the number that all values are; in words what they are if there is none."""
    numbers = set[float]()
    for value in values:
        number = _read(value)
        if number is None:
            return f"is no number but {value!r}"
        numbers.add(number)
    if len(numbers) == 1:
        return numbers.pop()
    return f"has several values: {', '.join(f'{x:g}' for x in sorted(numbers))}"


def _read(value: object) -> float | None:
    if isinstance(value, bool) or (isinstance(value, str) and "_" in value):
        return None
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None
