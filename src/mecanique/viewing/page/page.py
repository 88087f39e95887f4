"""One offline HTML page from a scene: self-contained, without requests or foreign scripts."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import posixpath
import re
import struct
from dataclasses import asdict, dataclass
from functools import cache
from html import escape
from pathlib import PurePosixPath
from typing import Any, final

from mecanique.viewing.page.keyframes import pack
from mecanique.viewing.page.panels import badge, fill, panels, read_asset, safe
from mecanique.viewing.page.surfaces import mesh_parcel
from mecanique.viewing.page.window import RecorderWindow, draw_bodies, solids_of, viewer_directory
from mecanique.viewing.scene.inspection import Inspection
from mecanique.viewing.scene.scene import Scene

_KEPT, _FLEETING = 6, 1
"""Compression levels of a page in a file and of a live one; 9 takes half as long again."""


@final
@dataclass(frozen=True)
class Stream:
    """The source from which the page of a live view gets its frames."""

    identity: str
    sources: tuple[str, ...]


def page(scene: Scene, stream: Stream | None = None) -> str:
    """Return a scene as one HTML document that needs no network."""
    window = RecorderWindow()
    draw_bodies(scene.bodies, window)
    packed = pack(scene)
    meshes, mesh_bytes = mesh_parcel(scene.bodies, quick=stream is not None)
    live = stream and {"id": stream.identity, "first": float(scene.t[0])}
    engine = scene.engine
    header = _header(scene) | {
        "table": packed.header,
        "meshes": meshes,
        "live": live,
        "engine": engine and {**asdict(engine), "script": ""},
        "breaks": list(map(asdict, scene.breaks)),
        "modes": list(map(asdict, scene.modes)),
        "inspection": scene.inspection and _inspection(scene.inspection),
    }
    viewer, style, script = _viewer(), read_asset("page.css"), join_scripts()
    boot = read_asset("boot.js")
    connect = " ".join(stream.sources) if stream else "'none'"
    program = [engine.script] if engine else []
    tabs, inner = panels(scene, live=stream is not None and engine is None)
    subtitle = scene.document.subtitle
    parts = {
        "policy": escape(policy([boot, script, viewer, *program], [style], connect)),
        "title": escape(scene.title),
        "subtitle": f'<p dir="auto">{escape(subtitle)}</p>' if subtitle else "",
        "badge": badge(scene),
        "tabs": tabs,
        "panels": inner,
        "licenses": escape(_licenses()),
        "style": style,
        "parcel": _parcel(
            header,
            [packed.body, mesh_bytes, *window.commands()],
            _FLEETING if stream else _KEPT,
        ),
        "viewer": _compressed_viewer(),
        "program": _compress(engine.script.encode(), _KEPT) if engine else "",
        "script": _compressed_script(),
        "boot": boot,
    }
    return fill(read_asset("page.html"), parts)


def policy(scripts: list[str], styles: list[str], connect: str) -> str:
    """Return the Content-Security-Policy that admits the given scripts and styles alone."""
    inner = _viewer_styles()
    style = " ".join(map(_hash, [*styles, *inner])) if inner else "'unsafe-inline'"
    return (
        f"default-src 'none'; script-src {' '.join(map(_hash, scripts))}; style-src {style};"
        f" img-src data: blob:; connect-src {connect}; base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _header(scene: Scene) -> dict[str, Any]:
    """The scene's names and kinds, without its numbers."""
    number = {body.name: k for k, body in enumerate(scene.bodies)}
    ledger = scene.document.ledger
    return {
        "fileName": re.sub(r"[^\w.-]+", "_", scene.document.file_name)[:80].strip("._")
        or "mechanism",
        "planar": scene.planar,
        "ground": scene.ground,
        "bounds": None if scene.bounds is None else scene.bounds.tolist(),
        "bodies": [{"name": body.name, "solids": solids_of(body)} for body in scene.bodies],
        "arrows": [
            {"name": a.name, "kind": a.kind, "body": number[a.body], "unit": a.unit}
            for a in scene.arrows
        ],
        "lines": [{"name": line.name, "kind": line.kind} for line in scene.lines],
        "traces": [{"name": trace.name} for trace in scene.traces],
        "joints": [{**asdict(joint), "body": number[joint.body]} for joint in scene.joints],
        "series": [
            {
                "name": curve.name,
                "text": curve.name,
                "html": safe(curve.label),
                "unit": curve.unit,
                "group": curve.group,
                "shown": curve.shown,
            }
            for curve in scene.series
        ],
        "ledger": {
            "coordinates": list(ledger.coordinates),
            "rows": [row.name for row in ledger.rows],
        },
    }


def _inspection(inspection: Inspection) -> dict[str, Any]:
    """What the page draws of a description at rest."""
    notes = [
        {
            "severity": note.finding.severity,
            "bodies": note.bodies,
            "suspicious": note.suspicious,
        }
        for note in inspection.notes
    ]
    return {**asdict(inspection), "notes": notes}


def _parcel(header: dict[str, Any], parts: list[bytes], effort: int) -> str:
    """Length of the header, the header, and the parts, compressed."""
    text = json.dumps(header | {"parts": [len(part) for part in parts]}, ensure_ascii=True).encode()
    return _compress(b"".join([struct.pack("<I", len(text)), text, *parts]), effort)


def _compress(data: bytes, effort: int) -> str:
    return base64.b64encode(gzip.compress(data, effort, mtime=0)).decode()


@cache
def script_modules() -> tuple[str, ...]:
    """Return the names of the page's scripts; each follows those it imports."""
    modules: dict[str, None] = {}

    def load(name: str) -> None:
        folder = PurePosixPath(name).parent
        for source in re.findall(r'^import [^;]* from "(.+)\.js";', read_asset(f"{name}.js"), re.M):
            imported = posixpath.normpath(folder / source)
            if imported not in modules:
                load(imported)
        modules[name] = None

    load("main")
    return tuple(modules)


@cache
def join_scripts() -> str:
    """Return the page's script: all modules in one closure, where they find one another."""
    texts = []
    for name in script_modules():
        text = re.sub(r"^import [^;]*;\n", "", read_asset(f"{name}.js"), flags=re.MULTILINE)
        text = re.sub(r"^export ", "", text, flags=re.MULTILINE)
        texts.append(re.sub(r"^ *(//.*)?\n|^ +", "", text, flags=re.MULTILINE))
    return '(() => {\n"use strict";\n' + "\n".join(texts) + "})();\n"


@cache
def _compressed_script() -> str:
    return _compress(join_scripts().encode(), _KEPT)


@cache
def _viewer() -> str:
    return (viewer_directory() / "main.min.js").read_text(encoding="utf-8")


@cache
def _compressed_viewer() -> str:
    return _compress(_viewer().encode(), _KEPT)


@cache
def _viewer_styles() -> list[str]:
    """The styles meshcat's viewer puts into the page: an empty one and its control panel's."""
    style = re.search(r'"(\.dg ul\{(?:[^"\\]|\\.)*)"', _viewer())
    if not style:  # another version may write it differently
        return []
    plain = (
        style[1].replace("\\n", "\n").replace('\\"', '"').replace("\\'", "'").replace("\\\\", "\\")
    )
    return ["", plain]


@cache
def _licenses() -> str:
    """The notices of meshcat's viewer and of the libraries bundled in it."""
    folder = viewer_directory()
    texts = []
    meshcat = folder.parent / "LICENSE"
    if meshcat.is_file():
        texts.append("meshcat\n\n" + meshcat.read_text(encoding="utf-8"))
    bundled = folder / "main.min.js.THIRD_PARTY_LICENSES.json"
    if bundled.is_file():
        for package in json.loads(bundled.read_text(encoding="utf-8")):
            notice = package.get("licenseText") or package.get("license")
            texts.append(f"{package.get('name')} {package.get('version')}\n\n{notice}")
    return "\n\n----\n\n".join(text.strip() for text in texts)
