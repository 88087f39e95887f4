"""Pictures of a motion: the scene as pure data, one offline page, a live view."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from mecanique.derive.equations import Equations
    from mecanique.motion.motion import Motion
    from mecanique.verify.verdict import Verdict
    from mecanique.view.live import LiveView
    from mecanique.view.page import page, write_page

__all__ = ["LiveView", "export", "page", "view", "write_page"]

_HOMES = {"LiveView": "mecanique.view.live", "page": "mecanique.view.page", "write_page": "mecanique.view.page"}


def export(
    motion: Motion,
    path: str | PathLike[str],
    *,
    equations: Equations | Sequence[Equations] | None = None,
    verdict: Verdict | None = None,
) -> Path:
    """Write a motion as one HTML page that needs no network: 3-D motion, forces, equations, plots, verdict.

    Args:
        motion: what `simulate` returned.
        path: the file; it is replaced in one step, and its directory must exist.
        equations: what `derive` returned, one or several; by default every method derives them.
        verdict: what `verify` returned; by default the equations are compared at 100 states.

    Returns:
        The path written.

    Raises:
        InputError: if the directory does not exist, or the motion is none.
    """
    from mecanique.view.show import export as write

    return write(motion, path, equations=equations, verdict=verdict)


def view(motion: Motion, *, speed: float = 1.0, port: int = 0, open_browser: bool = True) -> None:
    """Show a motion live in a browser on this machine, until Ctrl-C or the end of the process.

    The server answers on 127.0.0.1 only, under a random token. Parameters and initial values can be changed in the
    page; the motion is then computed again.

    Args:
        motion: what `simulate` returned.
        speed: seconds shown per second.
        port: 0 takes any free port.
        open_browser: whether to open the page; its address is printed in any case.

    Raises:
        InputError: if the port is taken, the speed is not above 0, or the motion is none.
    """
    from mecanique.view.show import view as show

    show(motion, speed=speed, port=port, open_browser=open_browser)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
