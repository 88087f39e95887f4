"""Expand a xacro file with the library of that name (extra `xacro`).

Its own search for packages is replaced by that of meshes: the folders given, ROS_PACKAGE_PATH,
AMENT_PREFIX_PATH and the packages around the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any
from xml.dom import minidom

from mecanique.urdf.findings import Report
from mecanique.urdf.reading.meshes import MeshSearch
from mecanique.urdf.reading.xacro_places import Places
from mecanique.urdf.xml.parse import parse

__all__ = ["Properties", "expand", "find_properties"]

Properties = Mapping[str, float]
"""Values of properties and arguments instead of those written, by name."""


def expand(
    file: Path,
    arguments: Mapping[str, str],
    search: MeshSearch,
    report: Report,
    properties: Properties | None = None,
) -> tuple[bytes, Places] | None:
    """Return a xacro file as URDF, and where its elements come from; None if that is impossible.

    Args:
        file: the xacro file.
        arguments: values of its <xacro:arg>.
        search: finds packages.
        report: where faults are noted.
        properties: other values of properties that stand in the file itself.

    Why it cannot be expanded is reported.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        remedy = "pip install 'mecanique[xacro]', or expand it: xacro FILE.xacro > FILE.urdf."
        report.add("M006", 1, "", "it is a xacro file, and xacro is not installed", remedy)
        return None

    def find(package: str) -> str:
        folder = search.package(package)
        if folder is None:
            raise LookupError(f"package {package!r} is not found in {search.searched}")
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

    kept, plainly = substitution_args._eval_find, xacro.parse
    substitution_args._eval_find, xacro.parse = find, read
    try:
        xacro.init_stacks(str(file))
        document = xacro.parse(None, str(file))
        for name, value in (properties or {}).items():
            for element in document.getElementsByTagName("xacro:property"):
                if element.getAttribute("name") == name:
                    element.setAttribute("value", repr(value))
        xacro.process_doc(document, mappings=dict(arguments))
        places.take(document)
        return bytes(document.toprettyxml(indent="  ", encoding="utf-8")), places
    except Exception as error:
        # the library evaluates what stands in the file, and lets any error through
        said = " ".join(str(error).split()) or type(error).__name__
        remedy = "Mend it, or give its arguments (--arg NAME=VALUE) and packages (--package-path)."
        report.add("M006", 1, "", f"xacro does not expand it: {said}", remedy)
        return None
    finally:
        substitution_args._eval_find, xacro.parse = kept, plainly


def find_properties(file: Path) -> dict[str, float]:
    """Return the properties with plain numbers that stand in a xacro file, by name.

    Args:
        file: the xacro file; those of files that it includes are left out.
    """
    found: dict[str, float] = {}
    report = Report(str(file))
    try:
        root = parse(file.read_bytes(), report)
    except OSError:
        return {}
    for element in () if root is None else root.walk():
        if element.tag == "xacro:property":
            try:
                found[element.attributes["name"]] = float(element.attributes["value"])
            except (KeyError, ValueError):
                continue
    return found
