"""Check a submitted formula against a mechanism."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import final

import numpy as np

from mecanique.checking.budget import bound_work
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import (
    ReadText,
    Statement,
    define,
    define_joint_positions,
    read_answer,
)
from mecanique.checking.grammar.tree import Node
from mecanique.checking.judgement.formula import Judged, find_rounding, judge_formula
from mecanique.checking.judgement.motion import (
    CommonFactors,
    Residual,
    count_independent,
    count_missing,
    residuals,
)
from mecanique.checking.judgement.proof import Proof
from mecanique.checking.judgement.quantities import AskedQuantity, ask_for
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.checking.mistakes.search import Search
from mecanique.checking.mistakes.units import UnitMisfitError
from mecanique.checking.verdict import Check, Line, Mistake, Outcome
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import FormulaError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import say_unit

_STRETCHED = 1e-6
"""Largest relative difference at states near zero and far out, where more is lost to rounding."""

_DENOMINATOR = re.compile(r"/(\d+[^\W\d_]\w*)(?![\w({])")
"""A denominator of a number and letters without brackets, as in 3g/2l."""

_MOTION = ("equation of motion", "equations of motion", "state space")


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
            "frequency", "undamped frequency" or "damped frequency" (about zero, or "frequency at
            q = pi"), "period" (of small oscillations), "period from rest" (released
            at q0, with K(k) or an integral), "equilibrium" (all of them; a position
            begins where a coordinate is given again), "equilibrium of rod" (the balance of a free
            body, in the letters of its reactions), "equilibrium force" (that holds it at rest
            anywhere), "steady motion" (rates of uniform turning), "reaction", "state space",
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
    return _checker(mechanism, seed, frozenset(given)).check(text, ask, let)


def list_letters(
    mechanism: Mechanism,
    ask: str = "equation of motion",
    let: Sequence[str] | Mapping[str, str] = (),
    seed: int = 0,
    given: Iterable[str] = (),
) -> dict[str, str]:
    """Return the meaning of each letter that an answer to a question may contain."""
    return _checker(mechanism, seed, frozenset(given)).list_letters(ask, let)


@lru_cache(maxsize=32)
def _checker(mechanism: Mechanism, seed: int, given: frozenset[str]) -> Checker:
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
        self.search = Search(self.truth, KnownLetters.of(mechanism), bool(self._given))

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
                quantity = None if ask in _MOTION else self.ask(ask)
                # what is right does not depend on the text: it is derived before the clock starts
                self.truth.prepare()
                with bound_work():
                    check = self._judge(text, ask, quantity, let)
                    if check.outcome == "wrong":
                        return self._close_denominators(check, text, ask, quantity, let)
                    return check
        except FormulaError as error:
            if error.text or not text.strip():
                raise
            raise FormulaError(str(error), text) from None

    def _judge(
        self,
        text: str,
        ask: str,
        quantity: AskedQuantity | None,
        let: Sequence[str] | Mapping[str, str],
    ) -> Check:
        letters = self.find_letters(ask, let)[0]
        if quantity is None:
            if ask == "state space" and len(letters.rates) == 2 and not letters.find("x1"):
                # x1' = x2 is the usual form where there is a single coordinate
                letters = define(f"x1 = {self.mechanism.coordinates.names[0]}", letters)[2]
            return self._motion(read_answer(text, letters), text)
        reading = read_answer(text, letters)
        check = self._formula(reading, quantity, ask, text, self.truth)
        return self._hold_numbers(check, reading, ask, text)

    def _close_denominators(
        self,
        check: Check,
        text: str,
        ask: str,
        quantity: AskedQuantity | None,
        let: Sequence[str] | Mapping[str, str],
    ) -> Check:
        """Return the verdict with 3g/2l as 3g/(2l), if it is right with these brackets."""
        written = _DENOMINATOR.findall(text)
        if not written:
            return check
        try:
            again = self._judge(_DENOMINATOR.sub(r"/(\1)", text), ask, quantity, let)
        except FormulaError:
            return check
        if again.outcome == "wrong":
            return check
        forms = (f"/{below} is read as /({below}): write brackets" for below in written)
        return _with_form(again, *forms)

    def find_letters(
        self, ask: str, let: Sequence[str] | Mapping[str, str] = ()
    ) -> tuple[KnownLetters, AskedQuantity | None]:
        """Return the letters of a question, and the quantity that it asks for, if not motion."""
        if ask in _MOTION:
            return self._letters(let, self.truth.further_letters), None
        quantity = self.ask(ask)
        further = self._find_further(quantity.names)
        return self._letters(let, further, quantity.functions), quantity

    def list_letters(
        self, ask: str = "equation of motion", let: Sequence[str] | Mapping[str, str] = ()
    ) -> dict[str, str]:
        """Return the meaning of each letter that an answer to a question may contain."""
        letters, quantity = self.find_letters(ask, let)
        asked = quantity.names if quantity else ()
        units = {**self.search.units.of, **(quantity.dimensions if quantity else {})}
        meanings = {p.symbol: p.meaning for p in self.mechanism.parameters}
        listed = {}
        for name, kind in letters.kinds.items():
            said = meanings.get(name) or ("what is asked for" if name in asked else kind)
            dimension = units.get(name)
            unit = f" [{say_unit(dimension)}]" if dimension is not None else ""
            listed[name] = f"{said}{unit}"
        return listed

    def _find_further(self, names: Sequence[str]) -> list[str]:
        """Return the letters of a quantity that are not the mechanism's own."""
        known = {*self.mechanism.values, *self.mechanism.coordinates, *self.mechanism.velocities}
        return [name for name in names if name not in known]

    def ask(self, question: str, held: frozenset[str] | None = None) -> AskedQuantity:
        """Return the quantity in question; only the parameters held open vary, if given."""
        key = question, held
        if key not in self._asked:
            truth = self.truth if held is None else self.truth.hold(held)
            self._asked[key] = ask_for(truth, question)
        return self._asked[key]

    def _hold_numbers(self, check: Check, reading: ReadText, ask: str, text: str) -> Check:
        """Return the verdict with numbers in place of parameters, if it is right with these."""
        written = set[str]()
        for statement in reading.statements:
            written = written.union(*(side.letters for side in statement.sides))
        if check.outcome != "wrong" or not check.varied:
            return check
        kinds = {cause.kind for cause in check.causes}
        measured = any(name.startswith("[") for name in written)
        if "emptiness" in kinds or (measured and "units" in kinds):
            return check
        for varied, forms in self._list_numbers(written):
            truth = self.truth.hold(varied)
            again = self._formula(reading, self.ask(ask, varied), ask, text, truth)
            if again.outcome != "wrong":
                again = replace(again, exact=False)
                return _with_form(again, *forms) if forms else again
        return check

    def _list_numbers(self, written: set[str]) -> Iterator[tuple[frozenset[str], tuple[str, ...]]]:
        """Yield the parameters that still vary where others are numbers, and the form that it is.

        First those that the question does not give have letters, then those that are written.
        """
        if stated := self._given - written:
            yield self._parameters - stated, ()
        if not self._parameters <= written:
            yield self._parameters & written, (_VALUES_ONLY,)

    def _formula(
        self, reading: ReadText, quantity: AskedQuantity, ask: str, text: str, truth: Truth
    ) -> Check:
        """Return the verdict on formulas of a quantity."""
        judged = judge_formula(reading.statements, truth, quantity, text)
        matrix = self._explain_matrix(judged, quantity)
        several = len(judged) > 1
        lines = []
        proven = [self._is_proven(formula, quantity) for formula in judged]
        for number, formula in enumerate(judged, 1):
            causes: tuple[Mistake, ...] = ()
            if formula.holds and not proven[number - 1] and truth is self.truth:
                formula = self._judge_terms(formula, quantity, text)
            if formula.fault:
                causes = (Mistake("emptiness", formula.fault, equation=number if several else 0),)
            elif not formula.holds and formula.residual is not None:
                place = number if several else 0
                causes = self.search.mend(
                    formula.residual, place, text, quantity.dimensions, formula.series, quantity
                )
            elif not formula.holds and quantity.kind == "conserved" and formula.root is not None:
                place = number if several else 0
                causes = self.search.explain_constant(formula.root, place, text)
            outcome: Outcome = "right" if formula.holds else "wrong"
            if matrix and not formula.holds:
                causes = tuple(dict.fromkeys((*matrix, *causes)))
            shown = (*formula.forms, formula.rounding) if formula.rounding else formula.forms
            if formula.holds and shown:
                outcome = "right except for form"
            lines.append(Line(formula.statement.text, outcome, formula.worst, shown, causes))
        lacking = [name for formula in judged for name in formula.missing]
        check = self._conclude(ask, truth.sample, lines, lacking)
        exact = bool(judged) and all(proven)
        return replace(check, exact=exact, notes=(*reading.notes, *quantity.notes))

    def _conclude(
        self, ask: str, sample: Sample, lines: Sequence[Line], lacking: Sequence[str]
    ) -> Check:
        """Return the verdict on a whole answer, by those on its lines and what it lacks."""
        forms = [form for line in lines for form in line.forms]
        outcome: Outcome = "right except for form" if forms else "right"
        if any(line.outcome == "wrong" for line in lines):
            outcome, forms = "wrong", []
        elif lacking:
            outcome, forms = "incomplete", [*lacking, *forms]
        return Check(
            mechanism=self.mechanism.name,
            asked=ask,
            outcome=outcome,
            lines=tuple(lines),
            states=sample.count,
            varied=sample.varied,
            forms=tuple(dict.fromkeys(forms)),
            causes=tuple(dict.fromkeys(cause for line in lines for cause in line.causes)),
        )

    def _explain_matrix(
        self, judged: Sequence[Judged], quantity: AskedQuantity
    ) -> tuple[Mistake, ...]:
        """Return mistakes that lead to a whole mass matrix."""
        true = quantity.values
        differences = [
            formula.residual.values.whole for formula in judged if formula.residual is not None
        ]
        if quantity.kind != "matrix" or true is None or all(formula.holds for formula in judged):
            return ()
        if len(differences) != true[0].size:
            return ()
        given = true + np.stack(differences, axis=-1).reshape(true.shape)
        return self.search.explain_matrix(given)

    def _judge_terms(self, judged: Judged, quantity: AskedQuantity, text: str) -> Judged:
        """Return a formula that holds in the states, wrong for units or a term of no weight."""
        residual = judged.residual
        if residual is None:
            return judged
        if self.search.has_unit_fault(residual, text, quantity.dimensions):
            return replace(judged, fault="the units do not match")
        return replace(judged, fault=_name_idle(residual.find_idle(), text))

    def _is_proven(self, judged: Judged, quantity: AskedQuantity) -> bool:
        """Return whether a formula that holds can also be proven by algebra."""
        proof = self._proof(quantity.derivation)
        if not judged.holds or judged.root is None or proof is None:
            return False
        if quantity.kind == "conserved":
            return proof.prove_conservation(judged.root, KnownLetters.of(self.mechanism).rate_nodes)
        if quantity.kind == "up to a constant":
            return proof.prove_constant(judged.root, judged.series)
        return proof.prove_motion(judged.root, judged.series)

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
        its, units = self.search.units.of.get(name), self.search.units
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

    def _motion(self, reading: ReadText, text: str) -> Check:
        truth, statements, letters = self.truth, reading.statements, reading.letters
        equations = residuals(statements, truth, truth.sample, text)
        numbers, forms = self._with_numbers(equations, statements, text)
        equations = numbers or equations
        written = set().union(*(residual.root.letters for residual in equations))
        defined = {name: node for name, node in letters.defined.items() if "'" not in name}
        explained = [
            self._explain_rounding(residual, text) or causes
            for residual, causes in zip(
                equations, self.search.causes(equations, text, defined), strict=True
            )
        ]
        lines, sound, proven = [], [], True
        for number, (residual, causes) in enumerate(zip(equations, explained, strict=True), 1):
            proof = not numbers and self._is_motion_proven(residual)
            proven = proven and proof
            fault = self._find_fault(residual, text, proven=proof) if residual.holds else ""
            if fault:
                place = number if len(equations) > 1 else 0
                causes = (Mistake("emptiness", fault, equation=place),)
            factor = self.factors.explain(residual) if residual.holds and not fault else ""
            if not written & {*self.mechanism.coordinates, *truth.velocities}:
                # a motion without any force is no linearized one
                causes = tuple(cause for cause in causes if cause.kind != "linearized")
            lines.append(_line(residual, causes, factor, sound=residual.holds and not fault))
            if lines[-1].outcome != "wrong":
                sound.append(residual)
        wrong = [residual for residual in equations if not residual.holds]
        nv = self.mechanism.nv
        missing = count_missing(sound) if sound else nv
        lacking = [f"{missing} of {nv} equations missing"] if missing else []
        check = self._conclude("equation of motion", equations[0].sample, lines, lacking)
        check = replace(
            check,
            exact=check.outcome != "wrong" and proven,
            at=_state(max(wrong, key=lambda residual: residual.worst)) if wrong else None,
            independent=min(nv - missing, count_independent(sound)) if sound else 0,
            notes=reading.notes,
        )
        return _with_form(check, *forms) if forms else check

    def _explain_rounding(self, residual: Residual, text: str) -> tuple[Mistake, ...]:
        """Return the rounded number that explains a wrong equation, if there is one."""
        if residual.holds or self.search.has_unit_fault(residual, text):
            return ()
        rounding = find_rounding(residual, text)
        return (Mistake("rounding", rounding),) if rounding else ()

    def _is_motion_proven(self, residual: Residual) -> bool:
        """Return whether an equation holds and is proven."""
        proof = self._proof()
        return residual.holds and proof is not None and proof.prove_motion(residual.root)

    def _find_fault(self, residual: Residual, text: str, *, proven: bool) -> str:
        """Return why an equation that holds at the random states is no answer, "" if it is one."""
        if residual.emptiness or proven:
            return residual.emptiness
        if self.search.has_unit_fault(residual, text):
            return "the units do not match"
        stretched = self.truth.stretch(residual.sample)
        if stretched is None:
            return _name_idle(residual.find_idle(), text)
        values = residual.tape.evaluate(stretched.letters, stretched.count)
        far = replace(residual, values=values, sample=stretched)
        if far.worst <= _STRETCHED:
            return _name_idle(residual.find_idle(values), text)
        state = ", ".join(f"{name} = {x:.4g}" for name, x in _state(far).items())
        return f"it holds near the usual states only, not at {state}"

    def _with_numbers(
        self, equations: Sequence[Residual], statements: Sequence[Statement], text: str
    ) -> tuple[list[Residual], tuple[str, ...]]:
        """Return equations with numbers in place of parameters, if they are right with these."""
        truth = self.truth
        if not truth.sample.varied or all(residual.holds for residual in equations):
            return [], ()
        if any(self.search.has_unit_fault(residual, text) for residual in equations):
            return [], ()
        written = set().union(*(residual.root.letters for residual in equations))
        for varied, forms in self._list_numbers(written):
            again = residuals(statements, truth, truth.with_numbers(varied), text)
            if all(residual.holds for residual in again):
                return again, forms
        return [], ()


def _name_idle(term: Node | None, text: str) -> str:
    """Return in words that a term is too small to be judged, "" if there is none."""
    if term is None:
        return ""
    written = " ".join(text[term.start : term.end].split())
    return f"the term '{written}' is too small to be seen in any state; leave it out"


_VALUES_ONLY = "right for these values of the parameters only"


def _with_form(check: Check, *forms: str) -> Check:
    """Return a verdict with further deviations from the requested form."""
    outcome: Outcome = "right except for form" if check.outcome == "right" else check.outcome
    return replace(check, outcome=outcome, forms=tuple(dict.fromkeys((*forms, *check.forms))))


def _line(residual: Residual, causes: tuple[Mistake, ...], factor: str, *, sound: bool) -> Line:
    forms = []
    if sound:
        if not residual.is_affine:
            forms.append("not linear in the accelerations")
        elif residual.has_factor_of_velocities:
            forms.append("not divided by a common factor that depends on velocities")
        elif factor:
            forms.append(factor)
    outcome: Outcome = "wrong"
    if sound:
        outcome = "right except for form" if forms else "right"
    if causes and causes[0].kind in ("linearized", "rounding"):
        form = "linearized" if causes[0].kind == "linearized" else causes[0].text
        outcome, forms = "right except for form", [form]
    return Line(residual.statement.text, outcome, residual.worst, tuple(forms), causes)


def _state(residual: Residual) -> dict[str, float]:
    """Return the state with the largest difference, by letters that occur, except accelerations."""
    k = int(np.argmax(residual.relative))
    letters = residual.root.letters - set(residual.truth.accelerations) - {"pi"}
    # units, e.g. "[s]", are letters of the formula, but no part of the state
    names = sorted(letters & residual.sample.letters.keys())
    values = {
        name: np.broadcast_to(residual.sample.letters[name], (residual.sample.count,))
        for name in names
    }
    return {name: float(value[k]) for name, value in values.items()}
