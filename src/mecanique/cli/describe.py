"""Commands on descriptions: list them, write URDF, look for what is wrong, compare."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.exceptions import Exit

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.options import FileOptions, reads_files
from mecanique.cli.printing import inform, say, to_json
from mecanique.cli.words import Chosen, choose, find_file, report_errors, takes_system
from mecanique.files import name_file, write_text

if TYPE_CHECKING:
    from mecanique.model.mechanism.origin import Finding


@click.command("list", epilog="Example: mecanique list --tag pendulum")
@options.several("--tag", said="Only systems with this tag; repeatable.", metavar="TAG")
@options.as_json
@report_errors
def list_(tag: tuple[str, ...], as_json: bool) -> None:
    """List the textbook systems with their degrees of freedom N."""
    everyone = sorted((*mq.textbook.names(), *mq.textbook.names(corners=True)))
    entries = {name: mq.textbook.entry(name) for name in everyone}
    known = sorted(set().union(*(entry.tags for entry in entries.values())))
    for word in tag:
        if word not in known:
            raise mq.UnknownNameError("tag", word, known)
    rows = [_row(name) for name, entry in entries.items() if set(tag) <= set(entry.tags)]
    if as_json:
        say(to_json(rows))
        return
    name_width = max((len(row["name"]) for row in rows), default=0)
    title_width = max((len(row["title"]) for row in rows), default=0)
    for row in rows:
        columns = f"{row['name']:{name_width}}  {row['title']:{title_width}}"
        say(f"{columns}  N = {row['N']}  {', '.join(row['tags'])}")


@click.command(epilog="Example: mecanique urdf two_blocks -o two_blocks.urdf")
@options.system
@options.output("Write to this file instead of printing.")
@takes_system
def urdf(chosen: Chosen, output: Path | None) -> None:
    """Write a system as URDF."""
    if output is None:
        click.echo(mq.write_urdf(chosen.mechanism), nl=False)
    else:
        mq.write_urdf(chosen.mechanism, output)
        say(f"Wrote {output}")


@click.command(epilog="Example: mecanique lint panda --json")
@click.argument("file", metavar="FILE", help="A URDF, xacro, MJCF or SDF file, or a robot's name.")
@options.as_json
@click.option("--sarif", "as_sarif", is_flag=True, help="Print SARIF, for editors and code hosts.")
@click.option("--fix", is_flag=True, help="Make every safe repair in a copy.")
@click.option(
    "--balance",
    is_flag=True,
    help="With --fix: replace each physically impossible inertia by the nearest possible one, "
    "and report the changes.",
)
@options.output("Where to write the repaired copy; printed by default.")
@click.option(
    "--meshes",
    is_flag=True,
    help="Also read mesh files, to find centers of mass outside them and impossible densities.",
)
@report_errors
@reads_files
def lint(
    file: str,
    as_json: bool,
    as_sarif: bool,
    fix: bool,
    balance: bool,
    output: Path | None,
    meshes: bool,
    *,
    reading: FileOptions,
) -> None:
    """Report what is wrong in a URDF file.

    Of MJCF and SDF it says what keeps the file from being read, what is left out, and which bodies
    are impossible. The exit code is 1 if there are errors, 2 if the file cannot be read.
    """
    from mecanique.formats.locate import locate
    from mecanique.formats.read import name_format
    from mecanique.urdf import lint as linting

    if output is not None and not fix:
        raise mq.InputError("expected --fix with --output, which takes the repaired copy")
    if fix and Path(file).suffix == ".xacro":
        raise mq.InputError("expected a URDF file with --fix: repair a xacro file by hand")
    if balance and not fix:
        raise mq.InputError("expected --fix with --balance, which repairs a copy")
    path = locate(file, reading.package_path or None)
    word = not file.endswith((".urdf", ".xml", ".xacro"))
    path = path or (mq.robot(file) if word and file in mq.robots() else Path(file))
    if (form := name_format(path)) != "URDF":
        if fix or as_json or as_sarif or meshes:
            message = "expected URDF with --fix, --json, --sarif or --meshes"
            raise mq.InputError(f"{message}, got {form}: convert it first (mecanique convert)")
        mechanism = mq.read(path, package_path=reading.package_path or None)
        say(
            mechanism.about
            or f"{name_file(str(path))}: all of it is read, and no body is impossible"
        )
        raise Exit(int(any(body.as_given for body in mechanism.bodies)))
    findings = linting.lint(
        path,
        package_path=reading.package_path or None,
        arguments=reading.arguments,
        meshes=meshes,
    )
    if fix and not any(_unreadable(finding.code) for finding in findings):
        given = path.read_text(encoding="utf-8-sig")
        text = linting.mend(given, name=path.stem, balance=balance)
        for change in linting.find_balances(given) if balance else ():
            inform(f"nearest possible inertia, {change}")
        if output is None:
            click.echo(text, nl=False)
            raise Exit(_code(linting.lint(text)))
        write_text(output, text)
        findings = linting.lint(output)
    write = linting.as_text
    if as_json or as_sarif:
        write = linting.as_json if as_json else linting.as_sarif
    say(write(findings))
    raise Exit(_code(findings))


@click.command(epilog="Example: mecanique diff old.urdf new.urdf")
@click.argument("first", metavar="A", help="A URDF, xacro, MJCF or SDF file, robot or system.")
@click.argument("second", metavar="B", help="The other.")
@options.as_json
@report_errors
@reads_files
def diff(first: str, second: str, as_json: bool, *, reading: FileOptions) -> None:
    """List how two descriptions differ, largest effect first.

    Differences are weighed by their part in the dynamics. The exit code is 1 if there are any.
    """
    comparison = mq.diff(*(choose(word, reading=reading).mechanism for word in (first, second)))
    say(comparison.to_json() if as_json else str(comparison))
    if not comparison.same:
        raise Exit(1)


@click.command(epilog="Example: mecanique convert arm.urdf -o arm.xml")
@options.system
@options.output(
    "The file to write: .urdf for URDF, .xml or .mjcf for MJCF, .sdf for SDF.", required=True
)
@takes_system
def convert(chosen: Chosen, output: Path) -> None:
    """Convert a description to URDF, MJCF or SDF, and prove the result.

    The result is read again, by mecanique and by the format's engines where they are installed, and
    compared with the source at 100 random states. What the format cannot express is listed.
    The exit code is 1 if the result differs, or an engine refuses it.
    """
    from mecanique.formats.scope import SCOPES
    from mecanique.urdf.read import say_unread

    forms = {suffix: form for form, scope in SCOPES.items() for suffix in scope.suffixes}
    form = forms.get(output.suffix.lower())
    if form is None:
        raise mq.InputError(f"expected a file ending in {', '.join(forms)}, got {output.name!r}")
    conversion = mq.convert(chosen.mechanism, form)
    write_text(output, conversion.text)
    say(str(conversion))
    chosen.tell_omissions()
    origin = chosen.mechanism.origin
    if origin is not None and origin.form == "URDF" and (unread := say_unread(origin)):
        inform(unread)
    inform(f"Wrote {output}")
    if conversion.differs:
        raise Exit(1)


@click.command(epilog="Example: mecanique inertia arm.urdf --density 2700 --link wrist -o new.urdf")
@click.argument("file", metavar="FILE", help="A URDF file, or the name of a robot.")
@options.real(
    "--density",
    "Density of the bodies [kg/m³], e.g. 2700 for aluminum; by default each keeps its mass.",
)
@click.option("--collisions", is_flag=True, help="Use the <collision> shapes, not <visual>.")
@options.several(
    "--link", "links", said="With -o: change only this link; repeatable.", metavar="NAME"
)
@options.output("Write a copy with those inertias.")
@options.as_json
@report_errors
@reads_files
def inertia(
    file: str,
    density: float | None,
    collisions: bool,
    links: tuple[str, ...],
    output: Path | None,
    as_json: bool,
    *,
    reading: FileOptions,
) -> None:
    """Compare masses and inertias with those of the shapes.

    The shapes count as homogeneous. Primitives are computed in closed form, meshes (STL, OBJ,
    COLLADA) by their triangles; a mesh with holes is replaced by its convex hull.
    """
    from mecanique.formats.read import name_format

    path = find_file(file, reading)
    if path.suffix == ".xacro":
        raise mq.InputError("expected a URDF file: expand the xacro file first")
    if (form := name_format(path)) != "URDF":
        raise mq.InputError(f"expected URDF, got {form}: convert it first (mecanique convert)")
    comparison = mq.compare_inertias(
        path, density=density, collisions=collisions, package_path=reading.package_path or None
    )
    if links and output is None:
        raise mq.InputError("expected -o FILE with --link, which selects what to change in a copy")
    say(comparison.to_json() if as_json else str(comparison))
    if output is not None:
        write_text(output, comparison.write(links))
        inform(f"Wrote {output}")


def _code(findings: tuple[Finding, ...]) -> int:
    if any(_unreadable(finding.code) for finding in findings):
        return 2
    return 1 if any(finding.severity == "error" for finding in findings) else 0


def _unreadable(code: str) -> bool:
    return code.startswith("M0")


def _row(name: str) -> dict[str, Any]:
    """Return what `mecanique list` prints about a textbook system."""
    entry = mq.textbook.entry(name)
    parameters = {p.symbol: {"value": p.value, "unit": p.unit} for p in entry.parameters}
    return {
        "name": name,
        "title": entry.title,
        "N": _freedom(name),
        "source": entry.source,
        "parameters": parameters,
        "tags": list(entry.tags),
    }


def _freedom(name: str) -> int:
    """Return the degrees of freedom of a textbook system; only constraints need the engine."""
    mechanism = mq.textbook.load(name)
    if not mechanism.constrained:
        return mechanism.nv
    from mecanique.reference import degrees_of_freedom

    return int(degrees_of_freedom(mechanism, mq.textbook.entry(name).start).N)
