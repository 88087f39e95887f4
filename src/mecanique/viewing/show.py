"""Show a motion as one offline page."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from mecanique.derivation.equations import Equations
from mecanique.derivation.switching import Modes
from mecanique.errors import InputError, MecaniqueError
from mecanique.files import require_directory, write_text
from mecanique.model.mechanism_units import units
from mecanique.motion.motion import Motion
from mecanique.verification import verify
from mecanique.verification.verdict import Verdict
from mecanique.viewing.engine import computed_scene
from mecanique.viewing.page.page import LEAST_FRAMES, SHORT, page, resample
from mecanique.viewing.scene.from_motion import actions_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.scene.texts import derive_all, document_of


def scene(
    motion: Motion,
    equations: Equations | Modes | Sequence[Equations] | None = None,
    verdict: Verdict | None = None,
) -> Scene:
    """Return a motion with all its texts, as pure data."""
    if not isinstance(motion, Motion):
        raise InputError(f"expected a Motion, as simulate returns it, got {type(motion).__name__}")
    modes = equations if isinstance(equations, Modes) else None
    if isinstance(equations, Modes):
        equations = ()
    elif isinstance(equations, Equations):
        equations = (equations,)
    elif equations is None:
        switches = bool(motion.described.switching)
        equations = () if switches else tuple(derive_all(motion.described))
    if verdict is None:
        with suppress(MecaniqueError):
            verdict = verify(motion.described)
    motion = _take_frames(motion)
    actions = actions_of(motion)
    document = document_of(motion, equations, verdict, actions, modes)
    return computed_scene(motion, document, actions, equations)


TURN, MOST_TURNED_FRAMES = 0.5, 601
"""A body turns at most this far between two frames [rad], for which at most so many are made."""


def _take_frames(motion: Motion) -> Motion:
    """Return a motion at the times that a page plays: fewer of a long one, more of a fast one."""
    times = resample(motion.t)
    length, unit = float(times[-1] - times[0]), units(motion.mechanism)
    turns = [unit[name] == "rad/s" for name in motion.mechanism.velocities]
    turned = length * float(np.abs(motion.v[:, turns]).max(initial=0.0))
    least = max(LEAST_FRAMES * (length <= SHORT), min(int(turned / TURN), MOST_TURNED_FRAMES))
    if len(times) < least and length > 0:
        times = np.linspace(times[0], times[-1], least)
    if times is motion.t:
        return motion
    state = motion(times)
    return replace(motion, t=times, q=state.q, v=state.v, path=motion.curve)


def export(
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    equations: Equations | Modes | Sequence[Equations] | None = None,
    verdict: Verdict | None = None,
) -> Path:
    """Write a motion as one offline HTML page: 3-D motion, forces, equations, plots, verdict.

    All methods derive the equations for it, and the reference gives the forces at each of up to
    7,200 instants, which takes seconds, longer than most motions.

    Args:
        motion: what `simulate` returned.
        path: the file; it is replaced in one step, and its directory must exist.
        equations: what `derive` returned, one or several, or `derive_modes`; by default every
            method derives them.
        verdict: what `verify` returned; by default the equations are compared at 100 states.

    Returns:
        The path written.

    Raises:
        InputError: if the directory does not exist, or it is no motion.

    Example:
        >>> pendulum = mq.textbook.load("simple_pendulum")
        >>> motion = mq.simulate(pendulum, q={"q": 1.0}, duration=1.0)
        >>> mq.export(motion, "pendulum.html").name
        'pendulum.html'
    """
    target = require_directory(path)
    return write_text(target, page(scene(motion, equations, verdict)))


def frame(motion: Motion) -> str:
    """Return a motion's page in a frame for a notebook, isolated from everything around it."""
    text = escape(page(scene(motion)), quote=True)
    return (
        f'<iframe sandbox="allow-scripts allow-downloads" title="{escape(repr(motion))}"'
        f' srcdoc="{text}" style="width: 100%; height: 600px; border: 0"></iframe>'
    )
