"""Format one derivation, or all of them in textbook order, for `mecanique derive`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

import mecanique as mq
from mecanique.cli.printing import inform

Form: TypeAlias = Literal["text", "latex", "mathml"]


def derivation(
    mechanism: mq.Mechanism, method: str, form: Form, steps: bool, *, units: bool = False
) -> str:
    """Return the equations of motion by one method, with what each symbol means.

    Those that cannot be read, or are too long for that, are a list of named results.
    """
    equations = mq.derive(mechanism, method=method)
    if not equations.legible:
        if equations.symbolic:
            inform(
                f"The equations have {equations.terms:,} terms: here they are a list of named "
                "results; in Python, mecanique.derive(…).text() writes them out"
            )
        written = mq.write_recursion(equations)
        return {"text": written.text, "latex": written.latex, "mathml": written.mathml}[form]()
    if units:
        from mecanique.model.units import add_unit

        lines = zip(map(str, equations.equations), equations.units, strict=True)
        return "\n".join(add_unit(line, unit) for line, unit in lines)
    return {"text": equations.text, "latex": equations.latex, "mathml": equations.mathml}[form](
        steps=steps, symbols=True
    )


def derivations(mechanism: mq.Mechanism, form: Form) -> str:
    """Return the derivations by all methods with every step, and whether they agree."""
    from mecanique.derivation import readable
    from mecanique.derivation.methods import agreement
    from mecanique.derivation.printing.prose import to_latex

    shortest = mq.derive(mechanism)
    if shortest.symbolic and not shortest.legible:  # the others are longer and take minutes
        return derivation(mechanism, shortest.method, form, steps=True)
    parts = [derivation(mechanism, method, form, steps=True) for method in readable(mechanism)]
    try:
        said = agreement(mechanism)
    except mq.DerivationError as error:
        said = f"Not compared with other closed forms: {error}."
    shown = {"text": said, "mathml": f"<p>{said}</p>", "latex": to_latex(said, ())}
    parts.append(shown[form])
    return ("\n\n\n" if form == "text" else "\n\n").join(parts)


def reduction(mechanism: mq.Mechanism, form: Form, steps: bool) -> str:
    """Return the equations reduced by the momenta of the cyclic coordinates."""
    found = mq.routh(mechanism)
    return {"text": found.text, "latex": found.latex, "mathml": found.mathml}[form](steps=steps)


def in_one_coordinate(mechanism: mq.Mechanism, coordinate: str, form: Form, steps: bool) -> str:
    """Return the equation of a mechanism with loops in one coordinate alone."""
    found = mq.reduce_loops(mechanism, coordinate)
    return {"text": found.text, "latex": found.latex, "mathml": found.mathml}[form](steps=steps)


def as_document(fragments: Sequence[str]) -> str:
    """Return fragments of LaTeX as a complete file."""
    from mecanique.derivation.document import to_page

    return to_page(fragments)
