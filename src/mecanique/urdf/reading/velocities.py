"""Constraints on velocities in URDF: an element of our own, which other programs ignore.

    <mecanique:velocity_constraint name="edge" rate="0">
      <mecanique:term joint="slide_x" coefficient="sin(turn)"/>
      <mecanique:term joint="slide_y" coefficient="-cos(turn)"/>
    </mecanique:velocity_constraint>

It says Σ coefficient × velocity = rate of joints with one coordinate each; coefficients and rate
are expressions in the joints' positions, by the joints' names, and in time t.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, final

from mecanique.model.constraints.velocity_constraints import VelocityConstraint
from mecanique.model.expression import FUNCTIONS, Scalar, coordinate, plain, symbols_in, time
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.urdf.dialect import TERM, VELOCITY_CONSTRAINT
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Comment, Element, Node, Tag
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of

_LONGEST = 2000
"""Characters of an expression; longer ones are refused."""

_OPERATIONS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_MOST = 100
"""Powers beyond this are refused, and powers of powers whose exponents multiply to more."""


@final
@dataclass(frozen=True)
class Between:
    """A constraint as it stands in the text, in the names of joints."""

    name: str
    terms: tuple[tuple[str, Scalar], ...]  # joint -> coefficient
    rate: Scalar

    def of(self, joints: Mapping[str, Joint]) -> VelocityConstraint:
        """Return it in the coordinates of the joints."""
        last = {name: joint.coordinates[-1] for name, joint in joints.items() if joint.coordinates}
        letters = {coordinate(name): coordinate(last.get(name, name)) for name in last}

        def put(scalar: Scalar) -> Scalar:
            scalar = plain(scalar)
            return scalar if isinstance(scalar, float) else scalar.subs(letters, simultaneous=True)

        terms = {last.get(name, name): put(factor) for name, factor in self.terms}
        return VelocityConstraint(self.name, terms, put(self.rate))


def constraint_node(mechanism: Mechanism, constraint: VelocityConstraint) -> Node:
    """Return the element of a constraint, or a comment where it is none of single joints."""
    owners = {
        joint.coordinate: joint.name
        for joint in mechanism.joints
        if isinstance(joint, Single) and joint.coordinate not in mechanism.coordinates.driven
    }
    terms = {name.removesuffix("'"): factor for name, factor in constraint.terms.items()}
    used = {symbol for scalar in constraint.scalars for symbol in symbols_in(scalar)}
    used -= {*mechanism.values, "t"}
    spoken = [owners.get(name, "") for name in {*terms, *used}]
    if not all(name.isidentifier() and name not in (*FUNCTIONS, "t") for name in spoken):
        return Comment(
            f"velocity constraint {constraint.name}: URDF has no tag for it, as it is one of "
            "coordinates that are none of single joints"
        )
    letters = {coordinate(symbol): coordinate(name) for symbol, name in owners.items()}
    values = {coordinate(symbol): value for symbol, value in mechanism.values.items()}

    def text(scalar: Scalar) -> str:
        scalar = plain(scalar)
        if not isinstance(scalar, float):
            scalar = scalar.subs(values).subs(letters, simultaneous=True)
        return write_expression(scalar)

    written = [
        Tag(TERM, joint=owners[name], coefficient=text(factor)) for name, factor in terms.items()
    ]
    rate = text(constraint.rate)
    return Tag(VELOCITY_CONSTRAINT, *written, name=constraint.name, rate=rate)


def read_velocity_constraint(
    element: Element, joints: Collection[str], names: Names, report: Report
) -> Between | None:
    """Return the constraint that an element describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"velocity constraint {name!r}"
    terms: list[tuple[str, Scalar]] = []
    sound = True
    for child in element.children:
        joint = name_of(child, report, "joint", where)
        factor = read_expression(child, "coefficient", report, where)
        if child.tag != TERM or joint is None or factor is None:
            sound = False
        elif joint not in joints:
            report.add("M603", child, where, f"{joint!r} is no joint")
            sound = False
        else:
            terms.append((joint, factor))
    rate = read_expression(element, "rate", report, where) if "rate" in element.attributes else 0.0
    if name is None or rate is None or not sound:
        return None
    return Between(names.free(name), tuple(terms), rate)


def read_expression(
    element: Element,
    attribute: str,
    report: Report,
    where: str,
    letters: str = "names of joints and t",
) -> Scalar | None:
    """Return an attribute as an expression in certain letters; nothing in it is executed."""
    text = element.attributes.get(attribute, "")
    try:
        if len(text) > _LONGEST:
            raise ValueError("it is too long")
        return plain(_value(ast.parse(text.strip(), mode="eval").body))
    except (SyntaxError, ValueError, ArithmeticError, RecursionError, MemoryError) as error:
        expected = f"expected an expression in {letters}"
        said = f"{expected} for {attribute} of <{element.tag}>, got {text[:60]!r} ({error})"
        report.add("M602", element, where, said)
        return None


def _value(node: ast.AST, most: float = _MOST) -> Any:
    """The value of an expression, in which nothing is raised to a power beyond the most."""
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return float(number) if isinstance(number, float) else number
        case ast.Name(id="t"):
            return time()
        case ast.Name(id=name):
            return coordinate(name)
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATIONS:
            return _OPERATIONS[type(op)](_value(operand, most))
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            power = _value(right)
            if not isinstance(power, (int, float)) or abs(power) > most:
                raise ValueError(f"its powers are to be numbers up to {_MOST} in all")
            return _value(left, most / max(abs(power), 1)) ** power
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATIONS:
            return _OPERATIONS[type(op)](_value(left, most), _value(right, most))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            import sympy

            return getattr(sympy, name)(_value(argument, most))
    raise ValueError(f"{ast.unparse(node)} is none")


def write_expression(expression: Scalar) -> str:
    """Return an expression as text, its numbers in full."""
    if isinstance(expression, float):
        return repr(expression)
    from sympy.printing.str import StrPrinter

    class Full(StrPrinter):  # type: ignore[misc]
        def _print_Float(self, number: Any) -> str:
            return repr(float(number))

    return str(Full().doprint(expression))
