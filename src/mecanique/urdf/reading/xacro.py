"""Expand a xacro file with the library of that name (extra `xacro`).

Its own search for packages is replaced by that of meshes: the folders given, ROS_PACKAGE_PATH,
AMENT_PREFIX_PATH and the packages around the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mecanique.urdf.findings import Report
from mecanique.urdf.reading.meshes import MeshSearch

__all__ = ["expand"]


def expand(
    file: Path, arguments: Mapping[str, str], search: MeshSearch, report: Report
) -> bytes | None:
    """Return the URDF text of a xacro file; None if it cannot be expanded, which is reported.

    Args:
        file: the xacro file.
        arguments: values of its <xacro:arg>.
        search: finds packages.
        report: where faults are noted.
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

    kept = substitution_args._eval_find
    substitution_args._eval_find = find
    try:
        document = xacro.process_file(str(file), mappings=dict(arguments))
        return bytes(document.toprettyxml(indent="  ", encoding="utf-8"))
    except Exception as error:
        # the library evaluates what stands in the file, and lets any error through
        said = " ".join(str(error).split()) or type(error).__name__
        remedy = "Mend it, or give its arguments (--arg NAME=VALUE) and packages (--package-path)."
        report.add("M006", 1, "", f"xacro does not expand it: {said}", remedy)
        return None
    finally:
        substitution_args._eval_find = kept
