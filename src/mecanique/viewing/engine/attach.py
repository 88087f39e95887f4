"""Attach an engine to a scene, and add a row on the page's program to the verdict."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.errors import MecaniqueError
from mecanique.generation.targets.javascript import JavaScript
from mecanique.generation.targets.python import Python
from mecanique.generation.verdict.cases import cases_of
from mecanique.generation.verdict.verdict import CodeVerdict, judge
from mecanique.model.mechanism import Mechanism
from mecanique.motion.analysis.forces import Action
from mecanique.motion.record.motion import Motion
from mecanique.textbook import load
from mecanique.textbook.catalogue import is_known
from mecanique.viewing.engine.make import Maker
from mecanique.viewing.scene.document import Document, VerdictTable
from mecanique.viewing.scene.from_motion import scene_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.scene.texts import quantities_of_inputs

SAMPLES = 100
"""Number of states at which a page's program is compared with Pinocchio."""

_SEED = 0


def computed_scene(
    motion: Motion, document: Document, actions: Sequence[Action], equations: Sequence[Equations]
) -> Scene:
    """Return the scene of a motion with its engine; without one, the page says why.

    Args:
        motion: what was simulated.
        document: the texts of the page.
        actions: the forces on the moving bodies, as many states as the motion has samples.
        equations: derived equations, one per method; the first is taken.
    """
    try:
        first = equations[0] if equations else derive(motion.mechanism)
        scene, maker = equip(motion, document, actions, first)
        verdict = add_row(document.verdict, judge_page(maker))
    except MecaniqueError as error:
        reason = f"This page shows a recorded motion and computes no other: {error}."
        return scene_of(motion, replace(document, recorded=reason), actions)
    return replace(scene, document=replace(scene.document, verdict=verdict))


def equip(
    motion: Motion, document: Document, actions: Sequence[Action], equations: Equations
) -> tuple[Scene, Maker]:
    """Return the scene of a motion with its engine, and what made it.

    Args:
        motion: what was simulated.
        document: the texts of the page.
        actions: the forces on the moving bodies, as many states as the motion has samples.
        equations: of motion.

    Raises:
        MecaniqueError: if a page cannot compute this motion.
    """
    mechanism = motion.mechanism
    maker = Maker(motion, equations)
    scene = maker.thin(scene_of(motion, document, actions, complete=True))
    constants = quantities_of_inputs(mechanism)
    document = replace(document, parameters=(*document.parameters, *constants))
    engine = maker.make(scene, write_python(mechanism))
    return replace(scene, engine=engine, document=document), maker


def judge_page(maker: Maker) -> CodeVerdict:
    """Run a page's program under node, or else as text in Python, and compare it with Pinocchio.

    Raises:
        MecaniqueError: if they disagree, or Pinocchio cannot treat the mechanism.
    """
    program = maker.proof()
    target = JavaScript() if shutil.which("node") else Python()
    return judge(program, target, cases_of(program, SAMPLES, _SEED), _SEED)


def add_row(table: VerdictTable, code: CodeVerdict) -> VerdictTable:
    """Return the verdict with a row on the page's program.

    Args:
        table: the verdict on the equations.
        code: the verdict on the program.
    """
    title = {
        "rhs": "rates of the state",
        "energy": "energies",
        "poses": "poses of bodies",
        "closure": "closure of loops",
    }
    own = tuple((title[name], f"{worst:.1e}") for name, worst in code.worst.items())
    run = code.versions.get("run by", "")
    note = (
        f"The program that this page computes with was run by {run} at {code.samples} random "
        f"states (seed {code.seed}), {code.varied} of them with other parameters."
    )
    return replace(table, own=own, own_note=note)


def write_python(mechanism: Mechanism) -> str:
    """Return the Python that makes a mechanism: from the catalogue, or from the URDF of the page.

    Args:
        mechanism: what moves.
    """
    if is_known(mechanism.name):
        known = load(mechanism.name)
        if tuple(known.coordinates) == tuple(mechanism.coordinates):
            values = {
                symbol: value
                for symbol, value in mechanism.values.items()
                if not np.isclose(value, known.values.get(symbol, np.nan), rtol=1e-15, atol=0)
            }
            changed = "".join(f", {symbol}={value!r}" for symbol, value in values.items())
            return f'mq.textbook.load("{mechanism.name}"{changed})'
    return f'mq.read_urdf("{mechanism.name}.urdf")'
