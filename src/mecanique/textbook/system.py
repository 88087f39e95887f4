"""An entry of the catalogue."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

from mecanique.errors import InputError, UnknownNameError
from mecanique.lazy import keep_garbage
from mecanique.model import Mechanism, Parameter
from mecanique.textbook.facts import Fact


@final
@dataclass(frozen=True, repr=False)
class System:
    """A textbook system: how to build it, its source, and a motion worth watching.

    Args:
        title: its description in one line.
        source: author, work, page, figure or equation.
        build: the mechanism with typical values, or what makes it: the parameters that it takes
            are passed by symbol, as are the whole-number options.
        parameters: its parameters with typical values; by default those of the mechanism.
        start: generalized coordinates at the start of the default motion; zero where left out.
        start_velocity: velocities at the start; zero where left out.
        duration: of the default motion [s].
        tags: words to find it by.
        options: whole numbers that change its structure, e.g. the number of links.
        facts: closed-form facts that the tests hold it to.
        forms: lines of its derivation by Lagrange, of Routh's reduction, of its loops' single
            equation or of small deviations as a book has them, each with the place there, or as
            this library does where books differ; a factor of parameters may have been divided out.
        statement: the problem in sentences, below a title; by default what the module that makes
            the mechanism says of itself.
    """

    title: str
    source: str
    build: Mechanism | Callable[..., Mechanism]
    parameters: tuple[Parameter, ...] = field(default=(), kw_only=True)
    start: Mapping[str, float] = field(default_factory=dict)
    start_velocity: Mapping[str, float] = field(default_factory=dict)
    duration: float = 10.0
    tags: tuple[str, ...] = ()
    options: Mapping[str, int] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    forms: Mapping[str, str] = field(default_factory=dict)
    statement: str = ""

    def __post_init__(self) -> None:
        if not self.parameters:
            built = self.build if isinstance(self.build, Mechanism) else self._typical
            object.__setattr__(self, "parameters", built.parameters)

    def __repr__(self) -> str:
        return f"<System: {self.title}>"

    def mechanism(self, **values: float) -> Mechanism:
        """Build the mechanism.

        Args:
            values: value of each parameter or option to change, by name.

        Raises:
            UnknownNameError: if a name is neither a parameter nor an option.
            InputError: if a value is not finite, or an option is no whole number of at least 1.
            MechanismError: if the mechanism is not sound with these values.
        """
        return self._build(values) if values else copy(self._typical)

    @cached_property
    def _typical(self) -> Mechanism:
        """The mechanism with the typical values; a copy of it needs no validation."""
        return self._build({})

    def _build(self, values: Mapping[str, float]) -> Mechanism:
        known = {parameter.symbol: parameter for parameter in self.parameters}
        for name in values:
            if name not in known and name not in self.options:
                raise UnknownNameError("parameter", name, [*known, *self.options])
        arguments: dict[str, Parameter | int] = dict(known)
        for name, default in self.options.items():
            number = values.get(name, default)
            if number != int(number) or number < 1:
                raise InputError(
                    f"expected a whole number of at least 1 for {name}, got {number!r}"
                )
            arguments[name] = int(number)
        mechanism = self.build
        if not isinstance(mechanism, Mechanism):
            asked = inspect.signature(mechanism).parameters
            if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in asked.values()):
                arguments = {name: given for name, given in arguments.items() if name in asked}
            with keep_garbage():  # it may be the first to import SymPy
                mechanism = mechanism(**arguments)
        mechanism = replace(mechanism, about=self.about)
        changed = {name: value for name, value in values.items() if name in known}
        return mechanism.replace(**changed) if changed else mechanism

    @property
    def about(self) -> str:
        """What it is, as its statement says it, and its source, in two lines."""
        said = self.statement
        if not (said or isinstance(self.build, Mechanism)):
            said = inspect.getdoc(inspect.getmodule(self.build)) or ""
        described = " ".join(said.partition("\n\n")[2].split())
        return f"{described or self.title}\nSource: {self.source}."
