"""Pack what a browser needs: the package, its pure dependencies and the viewer of its pages."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import mecanique as mq
from mecanique.viewing.page.page import viewer_directory

PURE = ("lark", "u-msgpack-python", "threadpoolctl")
"""Dependencies without compiled code; NumPy, SciPy and SymPy are Pyodide's own builds."""
VIEWER = "meshcat/viewer"
"""Where the viewer is looked for: meshcat itself, with its server, is not there."""


def pack(path: Path) -> None:
    """Write the archive that is unpacked beside Pyodide's standard library."""
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, file in files_of_package():
            archive.write(file, name)
        for package in PURE:
            for entry in distribution(package).files or ():
                if entry.suffix in (".py", ".lark") and not entry.is_absolute():
                    archive.write(Path(str(entry.locate())), entry.as_posix())
        viewer = viewer_directory()
        archive.write(viewer.parent / "LICENSE", f"{VIEWER}/LICENSE")
        for name in ("main.min.js", "main.min.js.THIRD_PARTY_LICENSES.json"):
            archive.write(viewer / name, f"{VIEWER}/dist/{name}")


def files_of_package() -> Iterator[tuple[str, Path]]:
    """Yield the files of the package itself, each with its name in the archive."""
    spec = find_spec(mq.__name__)
    assert spec is not None, "the package is imported above"
    assert spec.origin is not None, "it is no namespace"
    root = Path(spec.origin).parent
    for file in sorted(root.rglob("*")):
        if file.is_file() and file.suffix != ".pyc":
            yield f"{root.name}/{file.relative_to(root).as_posix()}", file
