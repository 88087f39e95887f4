"""Expand a xacro file with the library of that name (extra `xacro`).

Its own search for packages is replaced by that of meshes: the folders given, ROS_PACKAGE_PATH,
AMENT_PREFIX_PATH and the packages around the file.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any
from xml.dom import minidom

from mecanique.urdf.findings import Report
from mecanique.urdf.reading.packages import MeshSearch
from mecanique.urdf.reading.xacro_places import Places
from mecanique.urdf.reading.xacro_values import Values


def expand(
    file: Path, values: Values, search: MeshSearch, report: Report
) -> tuple[bytes, Places] | None:
    """Return a xacro file as URDF, and where its elements come from; None if that is impossible.

    Args:
        file: the xacro file.
        values: of its arguments and properties, which are noted there.
        search: finds packages.
        report: where faults are noted.

    Why it cannot be expanded is reported.

    Raises:
        UnknownNameError: if it has no such argument.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        remedy = "pip install 'mecanique[xacro]', or expand it: xacro FILE.xacro > FILE.urdf."
        report.add("M006", 1, "", "it is a xacro file, and xacro is not installed", remedy)
        return None

    lost: list[str] = []

    def find(package: str) -> str:
        folder = search.package(package)
        if folder is None:
            lost.append(f"package {package!r} is not found in {search.searched}")
            raise LookupError(lost[-1])
        return str(folder)

    places = Places()

    def read(inp: Any, filename: str | None = None) -> Any:
        """Parse what xacro asks for, with a number in each element."""
        if inp is not None or filename is None:
            return plainly(inp, filename)
        path = file.parent / filename
        try:
            text = path.read_bytes()
        except OSError:
            return plainly(inp, filename)
        shown = path
        with suppress(ValueError):
            shown = file.parent / path.resolve().relative_to(file.parent.resolve())
        return minidom.parseString(places.mark(text, str(shown)))

    def define(element: Any, table: Any) -> None:
        values.define(element, table, grab)

    kept, plainly, grab = substitution_args._eval_find, xacro.parse, xacro.grab_property
    substitution_args._eval_find, xacro.parse, xacro.grab_property = find, read, define
    try:
        xacro.init_stacks(str(file))
        document = xacro.parse(None, str(file))
        xacro.process_doc(document, mappings=values.arguments)
        places.take(document)
        text = bytes(document.toprettyxml(indent="  ", encoding="utf-8"))
    except Exception as error:
        # the library evaluates what stands in the file, and lets any error through
        said = " ".join(str(error).split()).rstrip(".") or type(error).__name__
        remedy = "Mend it, or give its arguments (--arg NAME=VALUE)."
        if lost:
            said = lost[-1]
            remedy = "Add its folder to --package-path, ROS_PACKAGE_PATH or AMENT_PREFIX_PATH."
        report.add("M006", 1, "", f"xacro does not expand it: {said}", remedy)
        return None
    finally:
        substitution_args._eval_find, xacro.parse, xacro.grab_property = kept, plainly, grab
    values.refuse_unknown()
    return text, places
