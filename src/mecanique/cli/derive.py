"""Commands that derive equations of motion and write them as text or as code."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

import click

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.printing import inform, say, to_json, working
from mecanique.cli.words import Chosen, takes_system

if TYPE_CHECKING:
    from mecanique.derivation.switching import Modes

SAMPLES = 20
"""Random states at which a document's derivations are compared."""

MOST_CUT = 6
"""Bodies of which a document shows the forces."""

LONG = 14
"""Of derivations with longer names fewer stand beside each other in a table."""

Form: TypeAlias = Literal["text", "latex", "mathml"]


@click.command(epilog="Example: mecanique derive two_blocks --method all --steps")
@options.system
@click.option(
    "--method",
    default="lagrange",
    metavar="METHOD",
    help="lagrange, newton_euler, virtual_work, or all of them with every step.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "latex", "mathml"]),
    default="text",
    help="Output format.",
)
@click.option("--steps", is_flag=True, help="Show every step of the derivation.")
@click.option("--units", is_flag=True, help="Show the unit of each line's terms, in text.")
@click.option("--document", is_flag=True, help="Print a complete LaTeX file with every step.")
@click.option(
    "--routh",
    is_flag=True,
    help="Eliminate the cyclic coordinates by their momenta (Routh), and compare with the "
    "full equations.",
)
@click.option(
    "--in",
    "alone",
    metavar="COORDINATES",
    help="Reduce a mechanism by its constraints to equations in these coordinates, "
    "comma-separated; loops to one, by kinematic coefficients.",
)
@click.option(
    "--absolute",
    default="",
    metavar="NAME=LETTER",
    help="Use an absolute angle, called by this letter, in place of that in a hinge, "
    "comma-separated: theta=chi.",
)
@click.option(
    "--solve",
    "solved",
    is_flag=True,
    help="Solve for the accelerations and the forces of constraints, where short enough.",
)
@takes_system
def derive(
    chosen: Chosen,
    method: str,
    form: Form,
    steps: bool,
    units: bool,
    document: bool,
    routh: bool,
    alone: str | None,
    absolute: str,
    solved: bool,
) -> None:
    """Derive the equations of motion; explain the symbols."""
    if absolute:
        letters = dict(_split(pair) for pair in absolute.split(","))
        chosen = replace(chosen, mechanism=chosen.mechanism.with_absolute_angles(letters))
    if units and (form != "text" or steps or document or method == "all"):
        raise click.BadParameter("expected --units without --steps, --format and --method all")
    reduced = alone is not None or solved
    if (routh and reduced) or ((routh or reduced) and (units or method != "lagrange")):
        raise click.BadParameter("expected one of --routh, --in or --solve, --units, --method")
    form, steps = ("latex" if document else form), steps or document
    with working("Deriving the equations of motion"):
        if chosen.mechanism.switching:
            stepwise = steps and not document
            if routh or reduced or units or stepwise or form == "mathml" or method != "lagrange":
                raise mq.InputError(
                    f"mechanism {chosen.mechanism.name!r} has elements that switch: its modes are "
                    "written as text or LaTeX by Lagrange's method alone; expected no other option "
                    "than -p, --format latex and --document"
                )
            modes = mq.derive_modes(chosen.mechanism)
            text = modes.latex() if form == "latex" else modes.text()
        elif routh:
            text = getattr(mq.routh(chosen.mechanism), form)(steps=steps)
        elif reduced:
            text = solution(chosen.mechanism, alone or "", form, steps)
        elif method == "all":
            text = derivations(chosen.mechanism, form)
        else:
            text = derivation(chosen.mechanism, method, form, steps, units=units)
    if document:
        from mecanique.derivation.document import to_page

        verdict = [judge(chosen.mechanism)] if method == "all" else []
        cut = method in ("all", "newton_euler")
        pictures = [*_pictures(chosen.mechanism, cut=cut)]
        figure, bodies = map(set_in_rows, (pictures[:1], pictures[1:]))
        # below what the system is, the figure explains the letters that follow
        opening, *derived = re.split(r"(?=\\subsection\*)", text, maxsplit=1)
        about, *meanings = re.split(r"(?=\\begin\{description\})", opening, maxsplit=1)
        parts = [about, figure, *meanings, bodies, *derived, *verdict]
        text = to_page([part for part in parts if part], chosen.mechanism.name)
    say(text)


def _derive_modes(mechanism: mq.Mechanism) -> Modes:
    """Derive every mode; of too many those of one element alone."""
    try:
        return mq.derive_modes(mechanism)
    except mq.DerivationError:
        modes = mq.derive_modes(mechanism, only="single")
    inform(f"Of many modes {len(modes.modes)} are written, those of one element alone")
    return modes


@click.command(epilog="Example: mecanique code cart_pole --target c --what rhs,energy -o cart")
@options.system
@click.option(
    "--target",
    default="c",
    metavar="LANGUAGE",
    help="c, javascript, python, jax, casadi or fmu (FMI 3.0).",
)
@click.option(
    "--what",
    default="acceleration,energy",
    metavar="NAMES",
    help="Quantities, comma-separated: rhs, acceleration, mass_matrix, bias, gravity, "
    "forces, inverse_dynamics, energy, poses, jacobians, reactions; with loops also "
    "multipliers, closure; derivatives such as rhs_by_y, rhs_by_tau, energy_by_p.",
)
@options.output("Directory to write in.", default=Path(), metavar="DIR")
@click.option("--numbers", is_flag=True, help="Write parameters as numbers, not as arguments.")
@click.option("--name", metavar="NAME", help="Prefix of functions and files.")
@click.option("--samples", default=100, metavar="NUMBER", help="Number of states to compare.")
@options.seed
@options.start
@options.as_json
@takes_system
def code(
    chosen: Chosen,
    target: str,
    what: str,
    output: Path,
    numbers: bool,
    name: str | None,
    samples: int,
    seed: int,
    as_json: bool,
) -> None:
    """Write the equations of motion as code, checked by running it.

    A comparison test is written alongside. -q and -v apply to FMUs only. With friction or stops,
    --what is left aside: there is a function for every mode and every impact; of many modes, for
    those in which one element alone is closed or slips. An FMU solves all modes as it runs.
    """
    from mecanique.generation.identifiers import file_stem

    mechanism = chosen.mechanism
    if name is None and chosen.system in mq.robots():  # its file may call it otherwise
        name = file_stem(chosen.system.rpartition("/")[2])
    with working(f"Writing and running {target}"):
        made = mq.generate(
            _derive_modes(mechanism) if mechanism.switching else mq.derive(mechanism),
            target,
            what,
            parameters=() if numbers else None,
            name=name,
            q=chosen.start,
            v=chosen.velocity,
            samples=samples,
            seed=seed,
        )
    paths = made.write(output)
    if as_json:
        names = [answer.quantity.name for answer in made.program.answers]
        figures = {
            "files": [str(path) for path in paths],
            "operations": {name: made.count(name).total for name in names},
            "worst": None if made.verdict is None else made.verdict.worst,
        }
        say(to_json(figures))
        return
    for path in paths:
        say(f"Wrote {path}")
    say("Not run here; see the head of the file." if made.verdict is None else str(made.verdict))


def _split(pair: str) -> tuple[str, str]:
    """Return the two sides of NAME=LETTER."""
    name, _, letter = map(str.strip, pair.partition("="))
    if not letter:
        raise click.BadParameter(f"expected NAME=LETTER, got {pair!r}")
    return name, letter


def _pictures(mechanism: mq.Mechanism, *, cut: bool) -> Iterator[str]:
    """Yield the figure for a document, and if asked the bodies with mass cut free."""
    from mecanique.figure.draw import figure_tex
    from mecanique.textbook.catalogue import entry, is_known

    start = entry(mechanism.name).start if is_known(mechanism.name) else None
    bodies: list[str | None] = [None]
    if cut:
        massive = [body for body in mechanism.bodies if mechanism.evaluate(body.mass) > 0]
        bodies += [body.name for body in massive if body.name != mechanism.ground][:MOST_CUT]
    for body in bodies:
        with suppress(mq.MecaniqueError):
            yield figure_tex(mechanism, start, body)


def set_in_rows(pictures: Sequence[str]) -> str:
    """Return pictures side by side, as many in a row as fit."""
    rows = "\\hfil\n".join(f"$\\vcenter{{\\hbox{{{picture}}}}}$" for picture in pictures)
    breaking = "\\clubpenalty=0 \\widowpenalty=0"  # a page may end after any row
    return f"\\begin{{center}}{breaking}\n{rows}\n\\end{{center}}\n" if rows else ""


def judge(mechanism: mq.Mechanism) -> str:
    """Return a section of LaTeX with the differences of each derivation from the engine."""
    from mecanique.derivation.printing.prose import to_latex

    verdict = mq.verify(mechanism, samples=SAMPLES)
    if not verdict.rows:
        return ""
    ways = tuple(dict.fromkeys(row.sources[0] for row in verdict.rows))
    worst = {(row.quantity, row.sources[0]): row.worst for row in verdict.rows}
    quantities = tuple(dict.fromkeys(row.quantity for row in verdict.rows))
    at_once = 3 if max(map(len, ways)) > LONG else 5
    tables = []
    for k in range(0, len(ways), at_once):
        part = ways[k : k + at_once]
        rows = [" & ".join(["", *part])]
        for quantity in quantities:
            sizes = [worst.get((quantity, way)) for way in part]
            if sizes.count(None) == len(sizes):
                continue
            cells = ("" if size is None else _power(size) for size in sizes)
            rows.append(" & ".join([quantity.replace("_", "\\_"), *cells]))
        columns = "l" + "c" * len(part)
        inner = " \\\\\n".join(rows)
        tables.append(f"\\begin{{tabular}}{{{columns}}}\n{inner}\n\\end{{tabular}}")
    said = (
        f"Largest relative differences from {verdict.rows[0].sources[1]} at {SAMPLES} random "
        f"states: all {'agree' if verdict.agrees else 'do not agree'}."
    )
    shown = "\n\n\\bigskip\n".join(tables)
    return (
        f"\\subsection*{{Verdict}}\n{to_latex(said, ())}\n\\begin{{center}}\\footnotesize"
        f"\\setlength{{\\tabcolsep}}{{3pt}}\n{shown}\n\\end{{center}}"
    )


def _power(number: float) -> str:
    """Return a number as a digit times a power of ten, in LaTeX."""
    digit, exponent = f"{number:.0e}".split("e")
    return f"${digit} \\cdot 10^{{{int(exponent)}}}$" if number else "0"


def derivation(
    mechanism: mq.Mechanism,
    method: str,
    form: Form,
    steps: bool,
    *,
    units: bool = False,
    alone: bool = True,
) -> str:
    """Return the equations of motion by one method, with what each symbol means."""
    from mecanique.derivation import METHODS
    from mecanique.motion.linear.speeds import expand_start

    equations = mq.derive(mechanism, method=method)
    if not equations.legible:
        ride = expand_start(mechanism)
        if ride is not None:
            inform(
                "The exact equations are a list of named results: 'mecanique code' writes them as "
                "a program, and mecanique.write_recursion in Python as text"
            )
            return _join([getattr(ride.letters, form)()], form)
        if equations.symbolic:
            inform(
                f"The equations have {equations.terms:,} terms: here they are a list of named "
                "results; in Python, mecanique.derive(…).text() writes them out"
            )
        else:
            shorter = method != "lagrange" and mq.derive(mechanism).legible
            inform(
                f"The equations are a list of named results: {equations.why_not}"
                + ("; --method lagrange has a closed form" if shorter else "")
            )
        if mechanism.constrained and not alone:  # the lists of the others differ in few lines
            others = " or ".join(name for name in METHODS if name != method)
            inform(f"The other methods give lists as long: --method {others} writes one")
        return _join([getattr(mq.write_recursion(equations), form)()], form)
    if units:
        from mecanique.model.mechanism_units import add_unit

        lines = zip(map(str, equations.equations), equations.units, strict=True)
        return "\n".join(add_unit(line, unit) for line, unit in lines)
    closed_form: str = getattr(equations, form)(steps=steps, symbols=True)
    return closed_form


def derivations(mechanism: mq.Mechanism, form: Form) -> str:
    """Return the derivations by all methods with every step, and whether they agree."""
    from mecanique.derivation import METHODS
    from mecanique.derivation.methods import agreement
    from mecanique.derivation.printing.prose import to_latex

    shortest = mq.derive(mechanism)
    if not shortest.legible:
        return derivation(mechanism, shortest.method, form, steps=True, alone=False)
    derived = [mq.derive(mechanism, method=method) for method in METHODS]
    written = [x for x in derived if x.legible]
    documents = [replace(x.document, special=x is written[-1]) for x in written]
    parts, explained = list[str](), frozenset[str]()
    for equations in derived:
        if not equations.legible:
            parts.append(derivation(mechanism, equations.method, form, steps=True))
            continue
        k = written.index(equations)
        document = documents[k].set_beside(documents[:k], documents[k + 1 :])
        document = replace(document, explained=explained)
        parts.append(getattr(document, form)(steps=True, symbols=True))
        explained |= {name for meaning in document.meanings(steps=True) for name in meaning.names}
    try:
        said = agreement(mechanism)
    except mq.DerivationError as error:
        said = f"Not compared with other closed forms: {error}."
    shown = {"text": said, "mathml": f"<p>{said}</p>", "latex": to_latex(said, ())}
    parts.append(shown[form])
    return _join(parts, form)


def _join(parts: list[str], form: Form) -> str:
    return ("\n\n\n" if form == "text" else "\n\n").join(parts)


def solution(mechanism: mq.Mechanism, keep: str, form: Form, steps: bool) -> str:
    """Return the equations in some coordinates alone, or solved for the accelerations."""
    written: str
    names = [name.strip() for name in keep.split(",") if name.strip()]
    if mechanism.loops and len(names) < 2 and mq.degrees_of_freedom(mechanism).N == 1:
        written = getattr(mq.reduce_loops(mechanism, *names), form)(steps=steps)
    elif steps and not keep:  # the last section of which is the same
        written = derivation(mechanism, "lagrange", form, steps)
    else:
        written = getattr(mq.derive(mechanism).solved(names), form)(symbols=True)
    return written
