"""Find the description that a word names: in folders, archives and packages."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
import zipfile
from pathlib import Path, PurePosixPath

from mecanique.errors import InputError
from mecanique.files import UNPACKED
from mecanique.urdf.reading.packages import MeshSearch, PackagePath
from mecanique.urdf.robots import find_in_library

_MOST_BYTES, _MOST_FILES = 500_000_000, 20_000
"""Most that is unpacked from an archive."""

_SUFFIXES = (".urdf", ".xacro", ".sdf", ".xml", ".mjcf")
_ASIDE = ("scene", "mjx_", "package", "keyframe")
"""How files begin that are no robot themselves: scenes, variants for one program, and the like."""


def locate(word: str | os.PathLike[str], package_path: PackagePath | None = None) -> Path | None:
    """Return the file of a description that a word names, or None if it names none.

    A word may be a file, a folder with one robot (as in MuJoCo's menagerie), a zip archive, a file
    in one (`robots.zip/arm/arm.urdf`), `package://` or `model://`, or a name of the package
    robot_descriptions, where that is installed.
    """
    text, path = os.fspath(word), Path(word)
    if path.is_file() and path.suffix.lower() != ".zip":
        return path
    if path.is_dir():
        return _choose(path, text)
    scheme, separator, rest = text.partition("://")
    if separator and scheme in ("package", "model"):
        package, _, inside = rest.strip("/").partition("/")
        search = MeshSearch(Path.cwd() / "word", package_path)
        folder = search.package(package)
        if folder is None:
            raise InputError(f"package {package!r} is not found in {search.searched}")
        if ".." in PurePosixPath(inside).parts:
            raise InputError(f"expected a file of the package, got {text!r}")
        return locate(folder / inside, package_path)
    parts = PurePosixPath(text.replace("\\", "/")).parts
    for k, part in enumerate(parts, 1):
        archive = Path(*parts[:k])
        if part.lower().endswith(".zip") and archive.is_file():
            unpacked = _unpack(archive)
            if ".." in parts[k:]:
                raise InputError(f"expected a file of the archive, got {text!r}")
            target = unpacked.joinpath(*parts[k:])
            return _choose(target, text) if target.is_dir() else locate(target, package_path)
    return find_in_library(text)


def _choose(folder: Path, said: str) -> Path:
    """Return the one robot of a folder: of those nearest to its top, the one called after it.

    Refusals name it as it was said, which an archive's folder is not.
    """
    files = _list_descriptions(folder)
    if not files:
        raise InputError(f"{said}: expected a description in URDF, xacro, MJCF or SDF, found none")
    near = [path for path in files if len(path.parts) == len(files[0].parts)]
    if len(near) > 1:
        name = folder.resolve().name
        called = [p for p in near if p.stem == "model" or name in (p.stem, f"{p.stem}_description")]
        ending = [path for path in near if name.endswith(f"_{path.stem}")]
        bare = name.replace("_", "")  # fr3v2.xml in franka_fr3_v2
        ending = ending or [path for path in near if bare.endswith(path.stem.replace("_", ""))]
        near = called or ending or near
    if len(near) > 1:
        names = ", ".join(str(path.relative_to(folder)) for path in near[:10])
        more = f" and {len(near) - 10} more" if len(near) > 10 else ""
        raise InputError(f"{said}: expected one of its descriptions, {names}{more}; name one")
    return near[0]


def _list_descriptions(folder: Path) -> list[Path]:
    """Return what may be a robot in a folder, the nearest to its top first."""
    files = sorted(
        (path for path in folder.rglob("*") if path.suffix in _SUFFIXES and path.is_file()),
        key=lambda path: (len(path.parts), path),
    )
    return [path for path in files if not path.name.startswith(_ASIDE)] or files


def list_deeper(word: str | os.PathLike[str], chosen: Path) -> list[Path]:
    """Return the descriptions deeper in the folder that a word names than the one chosen of it."""
    files = _list_descriptions(Path(word)) if Path(word).is_dir() else []
    return [path for path in files if len(path.parts) > len(chosen.parts)]


def _unpack(archive: Path) -> Path:
    """Unpack an archive, within bounds, into a folder that lasts as long as the process."""
    try:
        with zipfile.ZipFile(archive) as file:
            members = [info for info in file.infolist() if not info.is_dir()]
            size = sum(info.file_size for info in members)
            if len(members) > _MOST_FILES or size > _MOST_BYTES:
                raise InputError(
                    f"{archive}: expected at most {_MOST_FILES:,} files and {_MOST_BYTES:,} bytes"
                )
            temporary = tempfile.mkdtemp(prefix="mecanique-")
            atexit.register(shutil.rmtree, temporary, ignore_errors=True)
            folder = Path(temporary) / archive.stem  # after which its robot may be called
            folder.mkdir()
            UNPACKED[str(folder)] = str(archive)
            for info in members:
                _unpack_file(file, info, folder, archive)
    except (OSError, zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
        raise InputError(f"{archive}: it cannot be unpacked ({error})") from None
    return folder


def _unpack_file(file: zipfile.ZipFile, info: zipfile.ZipInfo, folder: Path, archive: Path) -> None:
    """Unpack one file; no more of it is read than the size it states."""
    parts = PurePosixPath(info.filename.replace("\\", "/")).parts
    if not parts or ".." in parts or parts[0].startswith("/") or any(p[1:2] == ":" for p in parts):
        raise InputError(f"{archive}: {info.filename!r} leaves the archive")
    target = folder.joinpath(*parts)
    target.parent.mkdir(parents=True, exist_ok=True)
    with file.open(info) as source, target.open("wb") as sink:
        shutil.copyfileobj(source, sink)
