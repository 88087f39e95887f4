"""Show a description at rest in a browser: its bodies, its joints and its faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Finding
from mecanique.model.quaternions import from_matrices
from mecanique.urdf.lint import lint
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.scene.appearance import bodies_of, marks_of
from mecanique.viewing.scene.document import Document
from mecanique.viewing.scene.inspection import Inspection, inspection_of
from mecanique.viewing.scene.scene import Scene
from mecanique.wording import say_count


def inspect(
    mechanism: Mechanism,
    findings: Sequence[Finding] | None = None,
    *,
    q: Mapping[str, float] | Sequence[float] | None = None,
    port: int = 0,
    open_browser: bool = True,
) -> None:
    """Show a description at rest in a browser, with its findings beside it, until Ctrl-C.

    Sliders move the joints. Centers of mass, ellipsoids of inertia and the axes of joints are shown
    on request; links with an error or a warning are tinted. Nothing is simulated or derived.

    Args:
        mechanism: what `read_urdf` returned, or any mechanism.
        findings: what `lint` returned; by default the text it was read from is checked.
        q: where it stands at first: by coordinate name or shape (nq,).
        port: 0 takes any free port.
        open_browser: whether to open the page; its address is printed in any case.

    Raises:
        InputError: if it is no mechanism, or the port is taken.

    Example:
        >>> mq.inspect(mq.read_urdf(mq.robot("ur5_robot")), open_browser=False)
    """
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"expected a Mechanism, got {type(mechanism).__name__}")
    if findings is None:
        findings = _lint(mechanism)
    start = None if q is None else mechanism.position(q)
    scene = scene_at_rest(mechanism, inspection_of(mechanism, findings, start))
    with LiveView(scene, port=port, open_browser=open_browser, at_once=True) as live:
        try:
            live.announce()
            live.stream(lambda changes: (), hold=True)
        except KeyboardInterrupt:
            return


def _lint(mechanism: Mechanism) -> tuple[Finding, ...]:
    origin = mechanism.origin
    if origin is None:
        return ()
    return lint(origin.file or origin.text.decode("utf-8-sig", "replace"))


def scene_at_rest(mechanism: Mechanism, inspection: Inspection) -> Scene:
    """Return the scene of a description at rest.

    Args:
        mechanism: what was described.
        inspection: its links, joints and findings.
    """
    poses = inspection.poses()
    counted = say_count(len(mechanism.bodies) - 1, "moving link", "moving links")
    text = mechanism.origin.text.decode("utf-8", "replace") if mechanism.origin else ""
    return Scene(
        title=mechanism.name.replace("_", " ").capitalize(),
        t=np.zeros(1),
        bodies=bodies_of(mechanism),
        positions=poses[None, :, :3, 3],
        quaternions=from_matrices(poses[None, :, :3, :3]),
        joints=marks_of(mechanism),
        document=Document(
            subtitle=f"{counted}, {say_count(mechanism.nv, 'velocity', 'velocities')}, at rest",
            urdf=text,
            file_name=mechanism.name,
        ),
        inspection=inspection,
    )
