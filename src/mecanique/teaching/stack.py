"""Questions for STACK, the Moodle plugin that judges by Maxima, as Moodle's XML.

STACK's students cannot write primes: q' is dq and q'' is ddq, and both are shown with dots. An
answer is judged by putting the true accelerations in; where it is wrong, those of slips.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, final
from xml.sax.saxutils import escape

from mecanique.derivation import derive
from mecanique.errors import InputError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.teaching.exercise import Exercise

_MOST_EQUATIONS = 3
"""More accelerations have no closed form that Maxima compares in time."""

_RESERVED = {"e", "i", "j", "pi", "t", "lambda"}


def _list_slips(mechanism: Mechanism) -> Iterator[tuple[str, Mechanism]]:
    """Yield wrong mechanisms that students derive the equations of, each with its words."""
    if any(bool(component != 0) for component in mechanism.gravity):
        x, y, z = (-component for component in mechanism.gravity)
        turned = replace(mechanism, gravity=(x, y, z))
        yield "the sign of the force of gravity is wrong", turned
        yield "gravity is missing", replace(mechanism, gravity=(0.0, 0.0, 0.0))
    for body in mechanism.bodies[1:]:
        if any(bool(entry != 0) for entry in body.inertia):
            point = body.replace(inertia=(0.0,) * 6)
            bodies = tuple(point if other is body else other for other in mechanism.bodies)
            text = f"the inertia of '{body.name}' about its own center is missing"
            yield text, replace(mechanism, bodies=bodies)
    for force in mechanism.forces:
        others = tuple(kept for kept in mechanism.forces if kept is not force)
        yield f"the force of '{force.name}' is missing", replace(mechanism, forces=others)


@final
class _Maxima:
    """Writes formulas of a mechanism in Maxima's letters."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        if mechanism.constrained or not 0 < mechanism.nv <= _MOST_EQUATIONS:
            raise InputError(
                f"no question for STACK about {mechanism.name!r}: expected at most "
                f"{_MOST_EQUATIONS} coordinates without loops or rolling contacts"
            )
        if any(not velocity.endswith("'") for velocity in mechanism.velocities):
            raise InputError(f"no question for STACK about {mechanism.name!r}: it has quaternions")
        reserved = {*mechanism.coordinates, *mechanism.values} & _RESERVED
        if reserved:
            raise InputError(f"STACK has other meanings for {', '.join(sorted(reserved))}")

    @property
    def accelerations(self) -> list[str]:
        """The letters of the accelerations."""
        return [self._letter(f"{velocity}'") for velocity in self._mechanism.velocities]

    @staticmethod
    def _letter(name: str) -> str:
        stem = name.rstrip("'")
        return "d" * (len(name) - len(stem)) + stem

    def solve(self, mechanism: Mechanism) -> list[str] | None:
        """Return the accelerations of a mechanism; None if they cannot be solved for."""
        try:
            derived = derive(mechanism)
            rest = derived.Q - derived.h
            solved = derived.M.LUsolve(rest)
        except (MecaniqueError, ValueError):
            return None
        return [self.write(entry) for entry in solved]

    def write(self, formula: Any) -> str:
        """Return a formula of SymPy's in Maxima's notation."""
        from sympy import Symbol

        moved = {
            symbol: Symbol(self._letter(symbol.name))
            for symbol in formula.free_symbols
            if symbol.name.endswith("'")
        }
        return str(formula.subs(moved)).replace("**", "^")

    def display(self) -> str:
        """Return commands that show rates with dots."""
        lines = []
        for velocity in self._mechanism.velocities:
            stem = velocity.rstrip("'")
            for dots in ("'", "''"):
                shown = f"\\\\{'d' * len(dots)}ot{{{_latex(stem)}}}"
                lines.append(f'texput({self._letter(stem + dots)}, "{shown}");')
        return "\n".join(lines)


def _latex(name: str) -> str:
    letters = name.rstrip("0123456789")
    digits = name[len(letters) :]
    base = f"\\\\{letters}" if len(letters) > 1 else letters
    return f"{base}_{{{digits}}}" if digits else base


def write_stack(made: Sequence[Exercise], problem: str, figure: str) -> str:
    """Return Moodle's XML of a question with variants; the figure is SVG in base64."""
    exercise = made[0]
    mechanism, ask = exercise.mechanism, exercise.ask
    if ask != "equation of motion":
        raise InputError(f"no question for STACK about the {ask}; it asks for equations of motion")
    maxima = _Maxima(mechanism)
    true = maxima.solve(mechanism)
    if true is None:
        raise InputError(f"the accelerations of {mechanism.name!r} have no closed form")
    slips: list[tuple[str, list[str]]] = []
    for text, wrong in _list_slips(mechanism):
        solved = maxima.solve(wrong)
        if solved is not None and solved != true and solved not in [known for _, known in slips]:
            slips.append((text, solved))
    inputs = [f"ans{k + 1}" for k in range(mechanism.nv)]
    rates = maxima.accelerations
    hint = f"Write {rates[0][1:]} for the first and {rates[0]} for the second derivative."
    fields = "".join(f"<p>[[input:{name}]] [[validation:{name}]]</p>" for name in inputs)
    variables = [
        maxima.display(),
        f"acc: [{', '.join(rates)}];",
        f"ta: [{', '.join(true)}];",
        *(f"slip{k}: [{', '.join(solved)}];" for k, (_, solved) in enumerate(slips, 1)),
        f"variants: [{', '.join(_quote(variant.given) for variant in made)}];",
        "given: rand(variants);",
    ]
    question = [
        _text("questiontext", f"{problem}<p>{escape(hint)}</p>{fields}", figure),
        _text("generalfeedback", f"<pre>{escape(exercise.answer)}</pre>"),
        "<defaultgrade>1</defaultgrade><penalty>0.1</penalty><hidden>0</hidden>",
        "<idnumber></idnumber>",
        "<stackversion><text></text></stackversion>",
        _text("questionvariables", "\n".join(variables), html=False),
        _text("specificfeedback", "[[feedback:prt1]]"),
        _text("questionnote", "{@given@}", html=False),
        "<questionsimplify>1</questionsimplify><assumepositive>0</assumepositive>",
        "<assumereal>0</assumereal>",
        _text("prtcorrect", "Right."),
        _text("prtpartiallycorrect", "Partly right."),
        _text("prtincorrect", "Wrong."),
        "<multiplicationsign>none</multiplicationsign><sqrtsign>1</sqrtsign>",
        "<complexno>i</complexno><inversetrig>acos</inversetrig><logicsymbol>lang</logicsymbol>",
        "<matrixparens>[</matrixparens><variantsselectionseed></variantsselectionseed>",
        *(
            _input(name, f"{rate} = ta[{k}]")
            for k, (name, rate) in enumerate(zip(inputs, rates, strict=True), 1)
        ),
        _tree(inputs, slips),
        *(f"<deployedseed>{seed + 1}</deployedseed>" for seed in range(len(made))),
        _test(inputs, rates, "ta", "1", "prt1-1-T", 1),
        *(
            _test(inputs, rates, f"slip{k}", "0", f"prt1-{len(inputs) + k}-T", k + 1)
            for k in range(1, len(slips) + 1)
        ),
    ]
    body = "\n".join(question)
    name = f"<name><text>{escape(exercise.title)}</text></name>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<quiz>\n<question type="stack">\n{name}\n{body}\n</question>\n</quiz>\n'
    )


def _quote(text: str) -> str:
    return '"{}"'.format(text.replace("\\", "").replace('"', ""))


def _text(tag: str, text: str, figure: str = "", *, html: bool = True) -> str:
    form = ' format="html"' if html and tag != "questionvariables" else ""
    file = f'<file name="figure.svg" path="/" encoding="base64">{figure}</file>' if figure else ""
    return f"<{tag}{form}><text>{escape(text)}</text>{file}</{tag}>"


def _input(name: str, answer: str) -> str:
    # 4 inserts stars for spaces and between a number and a letter
    return (
        f"<input><name>{name}</name><type>algebraic</type><tans>{escape(answer)}</tans>"
        "<boxsize>60</boxsize><strictsyntax>1</strictsyntax><insertstars>4</insertstars>"
        "<syntaxhint></syntaxhint><syntaxattribute>0</syntaxattribute>"
        "<forbidwords>diff, int, solve</forbidwords><allowwords></allowwords>"
        "<forbidfloat>0</forbidfloat><requirelowestterms>0</requirelowestterms>"
        "<checkanswertype>1</checkanswertype><mustverify>1</mustverify>"
        "<showvalidation>1</showvalidation><options></options></input>"
    )


_VARIABLES = """harmonics(ex) := trigreduce(expand(trigexpand(ex)));
vanishes(ex) := is(fullratsimp(harmonics(num(factor(ex)))) = 0);
put(vals, ex) := subst(makelist(acc[k] = vals[k], k, 1, length(acc)), ex);
eqs: maplist(lambda([eq], lhs(eq) - rhs(eq)), [{inputs}]);
holds(vals) := every(vanishes, maplist(lambda([ex], put(vals, ex)), eqs));
good: sublist(eqs, lambda([ex], vanishes(put(ta, ex))));
rows: maplist(lambda([ex], maplist(lambda([a], diff(ex, a)), acc)), good);
linear: every(lambda([row], every(lambda([x], every(lambda([a], freeof(a, x)), acc)), row)), rows);
reduced: maplist(lambda([row], maplist(harmonics, row)), rows);
proved: if good = [] or not linear then 0 else rank(apply(matrix, reduced));"""


def _tree(inputs: Sequence[str], slips: Sequence[tuple[str, Sequence[str]]]) -> str:
    """Return the tree: how many independent equations are right, then the slips by name."""
    count, nodes = len(inputs), []
    for place in range(count):
        wanted = count - place
        said = "" if place == 0 else f"{wanted} of {count} independent equations are right."
        last = place + 1 < count or slips
        nodes.append(
            _node(
                place,
                ("proved", str(wanted)),
                (wanted / count, count if place and slips else -1, said),
                (0.0, place + 1 if last else -1, ""),
            )
        )
    for k, (text, _) in enumerate(slips, 1):
        following = count + k if k < len(slips) else -1
        said = f"A likely cause: {text}."
        nodes.append(
            _node(
                count + k - 1, (f"holds(slip{k})", "true"), (None, -1, said), (None, following, "")
            )
        )
    variables = _VARIABLES.format(inputs=", ".join(inputs))
    return (
        "<prt><name>prt1</name><value>1</value><autosimplify>1</autosimplify>"
        "<feedbackstyle>1</feedbackstyle>"
        f"<feedbackvariables><text>{escape(variables)}</text></feedbackvariables>"
        f"{''.join(nodes)}</prt>"
    )


def _node(
    place: int,
    asked: tuple[str, str],
    true: tuple[float | None, int, str],
    false: tuple[float | None, int, str],
) -> str:
    """Return a node: what is compared, and for each outcome the score, the next node, the words."""
    branches = ""
    for name, mark, (score, following, said) in (("true", "T", true), ("false", "F", false)):
        mode, points = ("=", score) if score is not None else ("+", 0.0)
        branches += (
            f"<{name}scoremode>{mode}</{name}scoremode><{name}score>{points:.4g}</{name}score>"
            f"<{name}penalty></{name}penalty><{name}nextnode>{following}</{name}nextnode>"
            f"<{name}answernote>prt1-{place + 1}-{mark}</{name}answernote>"
            f'<{name}feedback format="html"><text>{escape(said)}</text></{name}feedback>'
        )
    sans, tans = asked
    return (
        f"<node><name>{place}</name><description></description><answertest>AlgEquiv</answertest>"
        f"<sans>{sans}</sans><tans>{tans}</tans><testoptions></testoptions><quiet>1</quiet>"
        f"{branches}</node>"
    )


def _test(
    inputs: Sequence[str], rates: Sequence[str], values: str, score: str, note: str, number: int
) -> str:
    """Return a test that STACK runs: the answer with these accelerations, and what follows."""
    written = "".join(
        f"<testinput><name>{name}</name><value>{rate} = {values}[{k}]</value></testinput>"
        for k, (name, rate) in enumerate(zip(inputs, rates, strict=True), 1)
    )
    return (
        f"<qtest><testcase>{number}</testcase><description></description>{written}<expected>"
        f"<name>prt1</name><expectedscore>{score}</expectedscore><expectedpenalty>"
        f"{'0' if score == '1' else '0.1'}</expectedpenalty>"
        f"<expectedanswernote>{note}</expectedanswernote></expected></qtest>"
    )
