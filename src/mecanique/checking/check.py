"""Check a submitted formula against a mechanism."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import final

import numpy as np

from mecanique.checking.budget import SpentError, bound_work, stop_clock
from mecanique.checking.conventions import Prompt, read_as_usual
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import (
    ReadText,
    Statement,
    define,
    define_joint_positions,
)
from mecanique.checking.grammar.tape import find_error, find_rounding
from mecanique.checking.grammar.tree import Node
from mecanique.checking.judgement.formula import (
    Judged,
    count_independent,
    judge_formula,
)
from mecanique.checking.judgement.motion import CommonFactors, Residual, count_missing, count_rank
from mecanique.checking.judgement.proof import Proof
from mecanique.checking.judgement.quantities import AskedQuantity, ask_for
from mecanique.checking.judgement.truth import Truth
from mecanique.checking.mistakes.search import Search
from mecanique.checking.mistakes.units import UnitMisfitError
from mecanique.checking.verdict import Check, Line, Mistake, Outcome
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import FormulaError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.homogeneity import hides_units
from mecanique.model.units import say_unit

_STRETCHED = 1e-6
"""Largest relative difference at states near zero and far out, where more is lost to rounding."""

_UNITS = "the units do not match"
_SIZES = "it holds for the proportions of this mechanism only"

_DENOMINATOR = re.compile(r"/(\d+[^\W\d_]\w*)(?![\w({])")
"""A denominator of a number and letters without brackets, as in 3g/2l."""


def check(
    mechanism: Mechanism,
    text: str,
    ask: str = "equation of motion",
    let: Sequence[str] | Mapping[str, str] = (),
    seed: int = 0,
    given: Iterable[str] = (),
) -> Check:
    """Check whether a formula is right, and if not, find the likely mistake.

    The text is read by a grammar and never executed. It is compared with the in-house derivation in
    random states with random parameters. Equations may come in any order, be multiplied by factors,
    combined, or solved for accelerations.

    Args:
        mechanism: the mechanism.
        text: plain text, LaTeX, SymPy's text or MathML; one equation a line.
        ask: the quantity in question: "equation of motion", "kinetic energy", "potential energy",
            "Lagrangian", "energy", "mass matrix", "momentum of q", "conserved quantity",
            "frequency", "undamped frequency" or "damped frequency" (about zero, "frequency at
            q = pi" or "frequency at steady motion"), "period" (of small oscillations), "period
            from rest" (released at q0, with K(k) or an integral), "equilibrium" (all of them; a
            position begins where a coordinate is given again), "equilibrium of rod" (the balance
            of a free body, in the letters of its reactions), "equilibrium force" (that holds it at
            rest anywhere), "steady motion" (rates of uniform turning), "reaction", "state space",
            "Hamiltonian", "Hamilton's equations" (momenta p or p1, p2 …, or ptheta) or "transfer
            function of x from F".
        let: definitions of further letters, e.g. "J = m l^2/3", or a mapping from letter to
            formula.
        seed: of the random states.
        given: symbols of parameters whose values the question gives, so that an answer may state
            these in numbers, or leave out what a zero makes vanish.

    Returns:
        Whether it is right, and if not, the likely causes.

    Raises:
        FormulaError: if the text cannot be read, or not judged within 5 s; the message shows
            where.
        UnknownNameError: if there is no such question.
        InputError: if a definition is invalid.

    Example:
        >>> mq.check(mq.textbook.load('simple_pendulum'), "q'' + g/l sin q = 0").right
        True
    """
    mechanism.refuse_switching(
        "a formula is checked where the equations are those of one mode; mq.derive_modes writes "
        "those of each"
    )
    return checker_of(mechanism, seed, frozenset(given)).check(text, ask, let)


def list_letters(
    mechanism: Mechanism,
    ask: str = "equation of motion",
    let: Sequence[str] | Mapping[str, str] = (),
    seed: int = 0,
    given: Iterable[str] = (),
) -> dict[str, str]:
    """Return the meaning of each letter that an answer to a question may contain."""
    return checker_of(mechanism, seed, frozenset(given)).list_letters(ask, let)


@lru_cache(maxsize=32)
def checker_of(mechanism: Mechanism, seed: int = 0, given: frozenset[str] = frozenset()) -> Checker:
    """Return the checker of a mechanism, which is kept."""
    return Checker(mechanism, seed, given)


@final
class Checker:
    """Checks many answers on one mechanism, whose equations are derived once."""

    def __init__(self, mechanism: Mechanism, seed: int = 0, given: Iterable[str] = ()) -> None:
        self.mechanism = mechanism
        self._parameters = frozenset(p.symbol for p in mechanism.parameters)
        self._given = frozenset(given) & self._parameters
        # what a given zero makes vanish is not asked for
        self.truth = Truth(mechanism, seed, {s for s in self._given if not mechanism.values[s]})
        self._asked: dict[tuple[str, frozenset[str] | None], AskedQuantity] = {}
        self._proofs: dict[str, Proof] = {}
        self.factors = CommonFactors(self.truth)
        with_numbers = bool(self._given) or hides_units(mechanism)
        self.search = Search(self.truth, KnownLetters.of(mechanism), with_numbers)

    def check(
        self,
        text: str,
        ask: str = "equation of motion",
        let: Sequence[str] | Mapping[str, str] = (),
    ) -> Check:
        """Return the verdict on a text."""
        try:
            # a stranger's formula may overflow, and so may a quantity in a special state; what has
            # no value is judged as such, by all that is called from here
            with np.errstate(all="ignore"):
                # what is right does not depend on the text: it is derived before the clock starts
                self.ask(ask)
                self.truth.prepare()
                with bound_work():
                    check = self._judge(text, ask, let)
                    if check.outcome == "wrong":
                        return self._close_denominators(check, text, ask, let)
                    return check
        except FormulaError as error:
            if error.text or not text.strip():
                raise
            raise FormulaError(str(error), text) from None

    def _judge(self, text: str, ask: str, let: Sequence[str] | Mapping[str, str]) -> Check:
        letters, quantity = self.find_letters(ask, let)
        prompt = Prompt(self.mechanism, ask, quantity, self.truth.changing)
        answer = read_as_usual(text, letters, prompt)
        text, reading = answer.text, answer.reading
        judged = self._compare(reading, quantity, self.truth, text)
        judged = self._resize(judged, reading, ask, text)
        held = self._hold_numbers(judged, reading, quantity, ask, text)
        assembled = None if held else self._assemble(judged, reading, ask, text)
        held = held or assembled
        truth, judged, forms = held or (self.truth, judged, ())
        definitions = reading.letters.defined.items()
        defined = {name: node for name, node in definitions if "'" not in name}
        explained = self.search.explain(judged, quantity, text, defined)
        motion = quantity.kind == "motion"
        if not (held or any(explained)):
            explained = self._explain_numbers(reading, ask, text) or explained
        lines = [
            _line(formula, causes, motion=motion)
            for formula, causes in zip(judged, explained, strict=True)
        ]
        if answer.unread and any(line.outcome == "wrong" for line in lines):
            raise answer.unread
        missing = [name for formula in judged for name in formula.missing]
        check = Check(
            mechanism=self.mechanism.name,
            asked=quantity.name if motion else ask,
            outcome="right",
            lines=tuple(lines),
            states=truth.sample.count,
            varied=truth.sample.varied,
            exact=bool(judged) and all(formula.proven for formula in judged),
            causes=tuple(dict.fromkeys(cause for line in lines for cause in line.causes)),
            independent=count_independent(judged),
            needed=1 if quantity.kind == "free body" else judged[0].says.shape[1],
            notes=(*reading.notes, *quantity.notes, *([_ASSEMBLED] if assembled else [])),
        )
        if motion:
            equations = [formula.residual for formula in judged if formula.residual is not None]
            wrong = [residual for residual in equations if not residual.holds]
            sound = [
                residual
                for residual, line in zip(equations, lines, strict=True)
                if line.outcome != "wrong"
            ]
            nv = self.mechanism.nv
            lacking = count_missing(sound) if sound else nv
            missing += [f"{lacking} of {nv} equations missing"] if lacking else []
            independent = min(nv - lacking, count_rank(sound)) if sound else 0
            at = _state(max(wrong, key=lambda residual: residual.worst)) if wrong else None
            check = replace(check, at=at, independent=independent, needed=nv)
        return _conclude(check, missing, forms)

    def _close_denominators(
        self, check: Check, text: str, ask: str, let: Sequence[str] | Mapping[str, str]
    ) -> Check:
        """Return the verdict with 3g/2l as 3g/(2l), if it is right with these brackets."""
        written = _DENOMINATOR.findall(text)
        if not written:
            return check
        try:
            again = self._judge(_DENOMINATOR.sub(r"/(\1)", text), ask, let)
        except FormulaError:
            return check
        if again.outcome == "wrong":
            return check
        forms = (f"/{below} is read as /({below}): write brackets" for below in written)
        return _with_form(again, *forms)

    def find_letters(
        self, ask: str, let: Sequence[str] | Mapping[str, str] = ()
    ) -> tuple[KnownLetters, AskedQuantity]:
        """Return the letters of a question, and the quantity that it asks for."""
        quantity = self.ask(ask)
        own = {*self.mechanism.values, *self.mechanism.coordinates, *self.mechanism.velocities}
        further = [name for name in quantity.names if name not in own]
        letters = self._letters(let, further, quantity.functions)
        for alias, name in quantity.aliases.items():
            if letters.find(alias) is None:
                letters = define(f"{alias} = {name}", letters)[2]
        return letters, quantity

    def list_letters(
        self, ask: str = "equation of motion", let: Sequence[str] | Mapping[str, str] = ()
    ) -> dict[str, str]:
        """Return the meaning of each letter that an answer to a question may contain."""
        letters, quantity = self.find_letters(ask, let)
        asked = () if quantity.kind == "motion" else quantity.letters
        units = {**self.search.units.of, **quantity.dimensions}
        meanings = {p.symbol: p.meaning for p in self.mechanism.parameters}
        if derivation := self.truth.derivation:
            meanings |= dict.fromkeys(derivation.lengths, "length of a spring")
            meanings |= {f"lambda_{tie.name}": tie.meaning for tie in derivation.ties}
        meanings |= {alias: f"the same as {name}" for alias, name in quantity.aliases.items()}
        listed = {}
        for name, kind in letters.kinds.items():
            said = meanings.get(name) or ("what is asked for" if name in asked else kind)
            dimension = units.get(name)
            unit = f" [{say_unit(dimension)}]" if dimension is not None else ""
            listed[name] = f"{said}{unit}"
        for printed, name in letters.printed.items():
            listed.setdefault(printed, f"the same as {name}")
        return listed

    def ask(self, question: str, held: frozenset[str] | None = None) -> AskedQuantity:
        """Return the quantity in question; only the parameters held open vary, if given."""
        key = question, held
        if key not in self._asked:
            truth = self.truth if held is None else self.truth.hold(held)
            self._asked[key] = ask_for(truth, question)
        return self._asked[key]

    def _compare(
        self, reading: ReadText, quantity: AskedQuantity, truth: Truth, text: str
    ) -> list[Judged]:
        """Judge each line, and look again at those that hold in the states."""
        judged = judge_formula(reading.statements, truth, quantity, text)
        return [self._confirm(formula, quantity, truth, text) for formula in judged]

    def _confirm(self, judged: Judged, quantity: AskedQuantity, truth: Truth, text: str) -> Judged:
        """Return a formula proven, or with the fault or rounding that the states do not show."""
        residual = judged.residual
        motion = quantity.kind == "motion"
        usual = truth is self.truth
        if motion and residual is not None and not residual.holds:
            if usual and self.search.has_unit_fault(residual, text):
                return judged
            return replace(judged, rounding=find_rounding(residual.tape, residual.values, text))
        if not judged.holds:
            return judged
        if usual and self._is_proven(judged, quantity):
            judged = replace(judged, proven=True)
        elif residual is not None and (usual or motion):
            judged = replace(judged, fault=self._find_fault(residual, quantity, text))
        elif residual is None and usual and judged.root is not None:
            # lengths on which the closure of loops depends are the same in all states
            alone = Residual(judged.statement, judged.root, truth, truth.sample)
            if self.search.has_unit_fault(alone, text, quantity.dimensions):
                judged = replace(judged, fault=_UNITS)
        if motion and residual is not None and judged.holds:
            return replace(judged, forms=self.factors.list_forms(residual))
        return judged

    def _resize(
        self,
        judged: Sequence[Judged],
        reading: ReadText,
        ask: str,
        text: str,
        given: Collection[str] | None = None,
    ) -> list[Judged]:
        """Return formulas, with a fault where one holds for the proportions of the mechanism only.

        Loops are assembled from zero by the coordinates that are given, if any.
        """
        # what algebra proves, or rounding excuses, needs no other states
        doubtful = [f.holds and not (f.proven or f.rounding) for f in judged]
        if not any(doubtful):
            return [*judged]
        try:
            with stop_clock():  # closing loops anew is no work on the answer
                other = self.truth.resized
                other = other and (other if given is None else other.assemble(given))
                asked = other and ask_for(other, ask)
            if other is None or asked is None:
                return [*judged]
            again = judge_formula(reading.statements, other, asked, text)
        except SpentError:
            raise  # what is not compared is not right
        except InputError:
            return [*judged]  # with these proportions what is asked for does not exist
        return [
            replace(here, worst=there.worst, fault=_SIZES) if open_ and not there.agrees else here
            for here, there, open_ in zip(judged, again, doubtful, strict=True)
        ]

    def _hold_numbers(
        self,
        judged: Sequence[Judged],
        reading: ReadText,
        quantity: AskedQuantity,
        ask: str,
        text: str,
    ) -> tuple[Truth, list[Judged], tuple[str, ...]] | None:
        """Return the truth with numbers in place of parameters, if an answer is right with these.

        With it come the judgement and the form that it is.
        """
        written = _list_letters(reading.statements)
        if not self.truth.sample.varied or all(formula.agrees for formula in judged):
            return None
        motion = quantity.kind == "motion"
        wrong = [formula.residual for formula in judged if not formula.holds]
        if not motion and any(formula.fault not in ("", _SIZES) for formula in judged):
            return None
        # a number may stand for a quantity with a unit, unless it has a unit itself
        if (motion or any(name.startswith("[") for name in written)) and any(
            residual is not None and self.search.has_unit_fault(residual, text, quantity.dimensions)
            for residual in wrong
        ):
            return None
        alone = [self._parameters.isdisjoint(_list_letters([f.statement])) for f in judged]
        for varied, forms in self._list_numbers(written):
            if not varied and not all(a or f.holds for a, f in zip(alone, judged, strict=True)):
                continue  # beside lines with letters, those with numbers stand for themselves
            truth = self.truth.hold(varied)
            try:
                asked = self.ask(ask, varied)
            except InputError:
                continue  # with these numbers what is asked for does not exist
            again = self._compare(reading, asked, truth, text)
            if all(formula.agrees if motion else formula.holds for formula in again):
                if forms and self._omits_ones(reading, written, ask, text):
                    return None
                return truth, again, forms
        return None

    def _assemble(
        self, judged: Sequence[Judged], reading: ReadText, ask: str, text: str
    ) -> tuple[Truth, list[Judged], tuple[str, ...]] | None:
        """Return the same where loops are assembled as from zero, if it is right there."""
        if all(formula.holds for formula in judged):
            return None
        written = {name.rstrip("'") for name in _list_letters(reading.statements)}
        truth = self.truth.assemble(written)
        if truth is None or truth.sample.count == self.truth.sample.count:
            return None
        try:
            again = self._compare(reading, ask_for(truth, ask), truth, text)
        except SpentError:
            raise  # it may be right there
        except InputError:
            return None  # there is no such quantity there
        again = self._resize(again, reading, ask, text, written)
        return (truth, again, ()) if all(formula.holds for formula in again) else None

    def _explain_numbers(self, reading: ReadText, ask: str, text: str) -> list[tuple[Mistake, ...]]:
        """Return the likely causes of wrong lines with numbers in place of all parameters."""
        if self._parameters & _list_letters(reading.statements):
            return []
        try:
            truth, asked = self.truth.hold(frozenset()), self.ask(ask, frozenset())
        except InputError:
            return []
        search = Search(truth, reading.letters, with_numbers=True)
        judged = self._compare(reading, asked, truth, text)
        explained = search.explain(judged, asked, text, {})
        for k, residual in enumerate(formula.residual for formula in judged):
            if residual is not None and not (explained[k] or judged[k].holds):
                error = find_error(residual.tape, residual.values)
                explained[k] = (Mistake("number", error),) if error else ()
        return explained

    def _list_numbers(self, written: set[str]) -> Iterator[tuple[frozenset[str], tuple[str, ...]]]:
        """Yield the parameters that still vary where others are numbers, and the form that it is.

        First those that the question does not give have letters, then those that are written, and
        last those that are not given, though they be written.
        """
        if stated := self._given - written:
            yield self._parameters - stated, ()
        if not self._parameters <= written:
            yield self._parameters & written, (_VALUES_ONLY,)
        if self._given & written:
            yield self._parameters - self._given, (_VALUES_ONLY,)
        if self._parameters & written:
            yield frozenset(), (_VALUES_ONLY,)

    def _omits_ones(self, reading: ReadText, written: set[str], ask: str, text: str) -> bool:
        """Whether an answer with letters is right only where others, left out, are one."""
        # no number in it stands for them
        values = self.mechanism.values
        ones = {name for name in self._parameters - written - self._given if values[name] == 1.0}
        if not ones or not self._parameters & written:
            return False
        varied = self._parameters - ones
        try:
            asked, truth = self.ask(ask, varied), self.truth.hold(varied)
        except InputError:
            return False
        return all(f.agrees for f in self._compare(reading, asked, truth, text))

    def _is_proven(self, judged: Judged, quantity: AskedQuantity) -> bool:
        """Return whether a formula that holds can also be proven by algebra."""
        proof = self._proof(quantity.derivation)
        if judged.root is None or proof is None:
            return False
        if quantity.kind == "conserved":
            return proof.prove_conservation(judged.root, KnownLetters.of(self.mechanism).rate_nodes)
        if quantity.kind == "up to a constant":
            return proof.prove_constant(judged.root, judged.series)
        return proof.prove_motion(judged.root, judged.series)

    def _find_fault(self, residual: Residual, quantity: AskedQuantity, text: str) -> str:
        """Return why what holds at the random states is no answer, "" if it is one."""
        if self.search.has_unit_fault(residual, text, quantity.dimensions):
            return _UNITS
        motion = quantity.kind == "motion"
        stretched = self.truth.stretch(residual.sample) if motion else None
        if stretched is None:
            # off the true values, each letter by an amount of its own: where a factor vanishes, it
            # would hide the terms of the others
            asked = {
                name: 1.7 * value + 0.1 * k * np.abs(value)
                for k, (name, value) in enumerate(residual.sample.values.items())
                if name in quantity.names
            }
            return _name_idle(residual.find_idle(residual.evaluate(asked)), text)
        far = replace(residual, sample=stretched)
        if far.worst <= _STRETCHED:
            return _name_idle(residual.find_idle(far.values), text)
        state = ", ".join(f"{name} = {x:.4g}" for name, x in _state(far).items())
        return f"it holds near the usual states only, not at {state}"

    def _proof(self, derivation: Derivation | None = None) -> Proof | None:
        """Return a prover based on the equations of motion, or on another derivation."""
        derived = derivation or self.truth.derivation
        if derived is None:
            return None
        key = "balances" if derivation else "motion"
        if key not in self._proofs:
            self._proofs[key] = Proof(derived)
        return self._proofs[key]

    def _letters(
        self,
        let: Sequence[str] | Mapping[str, str],
        further: Sequence[str] = (),
        functions: Mapping[str, str] = MappingProxyType({}),
    ) -> KnownLetters:
        if isinstance(let, str):
            raise InputError(f"expected a list of definitions, got the text {let!r}")
        if isinstance(let, Mapping):
            let = [f"{name} = {formula}" for name, formula in let.items()]
        known = KnownLetters.of(self.mechanism, further, functions)
        letters = define_joint_positions(known, self.mechanism)
        for definition in let:
            name, formula, letters = define(definition, letters)
            self._refuse_other_unit(name, formula, definition)
        return letters

    def _refuse_other_unit(self, name: str, formula: Node, definition: str) -> None:
        """Refuse a letter of the system that is defined anew as a quantity of another kind."""
        its = self.search.units.of.get(name)
        units = self.search.units
        try:
            new = units.find(formula, "")
        except UnitMisfitError:
            return  # the answer that uses it says where
        if its is not None and new is not None and its != new:
            raise FormulaError(
                f"{name!r} is in {say_unit(its)}, its definition in {say_unit(new)}; define "
                "another letter",
                definition,
            )


def _name_idle(term: Node | None, text: str) -> str:
    """Return in words that a term is too small to be judged, "" if there is none."""
    if term is None:
        return ""
    return f"the term '{term.quote(text)}' is too small to be seen in any state; leave it out"


_VALUES_ONLY = "right for these values of the parameters only"
_ASSEMBLED = "compared for loops that are assembled starting from zero"


def _with_form(check: Check, *forms: str) -> Check:
    """Return a verdict with further deviations from the requested form."""
    outcome: Outcome = "right except for form" if check.outcome == "right" else check.outcome
    return replace(check, outcome=outcome, forms=tuple(dict.fromkeys((*forms, *check.forms))))


def _conclude(check: Check, missing: Sequence[str], forms: Sequence[str]) -> Check:
    """Return the verdict on a whole answer, by those on its lines and what it lacks."""
    of_lines = [form for line in check.lines for form in line.forms]
    if any(line.outcome == "wrong" for line in check.lines):
        check = replace(check, outcome="wrong")
    elif missing:
        check = replace(
            check, outcome="incomplete", forms=tuple(dict.fromkeys((*missing, *of_lines)))
        )
    elif of_lines:
        check = _with_form(check, *of_lines)
    return _with_form(check, *forms) if forms else check


def _line(formula: Judged, causes: tuple[Mistake, ...], *, motion: bool) -> Line:
    """Return the verdict on a line."""
    forms = (*formula.forms, formula.rounding) if formula.rounding else formula.forms
    outcome: Outcome = "wrong"
    if formula.holds:
        outcome = "right except for form" if forms else "right"
    if motion and causes and causes[0].kind == "linearized":
        outcome, forms = "right except for form", ("linearized",)
    return Line(formula.statement.text, outcome, formula.worst, forms, causes)


def _state(residual: Residual) -> dict[str, float]:
    """Return the state with the largest difference, by letters that occur, except accelerations."""
    k = int(np.argmax(residual.relative))
    letters = residual.root.letters - set(residual.truth.accelerations) - {"pi"}
    # units, e.g. "[s]", are letters of the formula, but no part of the state
    known = residual.sample.letters
    return {name: float(known[name][k]) for name in sorted(letters & known.keys())}


def _list_letters(statements: Sequence[Statement]) -> set[str]:
    """Return the letters of some lines."""
    return {name for line in statements for side in line.sides for name in side.letters}
