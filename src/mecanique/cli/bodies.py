"""The command on the bodies of a file: masses and inertias beside those of their shapes."""

from __future__ import annotations

from pathlib import Path

import click

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.printing import inform, say, write_text
from mecanique.cli.reading import Reading, reads_files
from mecanique.cli.words import find_file, report_errors


@click.command(epilog="Example: mecanique inertia arm.urdf --density 2700 --link wrist -o new.urdf")
@click.argument("file", metavar="FILE", help="A URDF file, or the name of a robot.")
@click.option(
    "--density",
    type=float,
    metavar="NUMBER",
    help="Density of the bodies [kg/m³], e.g. 2700 for aluminum; each keeps its mass by default.",
)
@click.option("--collisions", is_flag=True, help="Take the shapes of <collision>, not <visual>.")
@click.option(
    "--link",
    "links",
    multiple=True,
    metavar="NAME",
    help="With -o: change only this link; repeatable.",
)
@click.option("--output", "-o", type=options.PATH, help="Write a copy with the inertias by shape.")
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
    reading: Reading,
) -> None:
    """Compare masses and inertias with those of homogeneous bodies of the same shape.

    Primitives are computed in closed form, meshes (STL, OBJ, COLLADA) by their triangles; a mesh
    with holes stands for its convex hull.
    """
    path = find_file(file)
    if path.suffix == ".xacro":
        raise mq.InputError("expected a URDF file: expand the xacro file first")
    found = mq.compare_inertias(
        path, density=density, collisions=collisions, package_path=reading.package_path or None
    )
    if links and output is None:
        raise mq.InputError("expected -o FILE with --link: it says what to change in a copy")
    say(found.to_json() if as_json else str(found))
    if output is not None:
        write_text(output, found.write(links))
        inform(f"Wrote {output}")
