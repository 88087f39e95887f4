"""Systems that engines are compared on, and their final states as exactly as they can be had."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import ode

import mecanique as mq

__all__ = ["Case", "cases", "chain", "exact"]


class Case(NamedTuple):
    """A mechanism whose joint angles are its coordinates, and its start from rest."""

    name: str
    mechanism: mq.Mechanism
    q: np.ndarray
    span: float = 10.0
    error: float = 1e-10

    @property
    def start(self) -> np.ndarray:
        """Positions and velocities at the start."""
        return np.concatenate([self.q, np.zeros(len(self.q))])

    @property
    def rods(self) -> int:
        """Number of rods."""
        return self.mechanism.nv - (self.name == "cart_pole")


def chain(n: int) -> mq.Mechanism:
    """Uniform rods m = 1, l = 1, one hanging from the other, by relative angles."""
    m, length, g = (
        mq.Parameter("m", 1.0, "kg"),
        mq.Parameter("l", 1.0, "m"),
        mq.Parameter("g", 9.81, "m/s²"),
    )
    links = range(1, n + 1)
    return mq.Mechanism(
        name=f"chain{n}",
        bodies=(mq.Body("ground"), *(mq.Body(f"rod{i}", mq.rod(m, length)) for i in links)),
        joints=tuple(
            mq.Revolute(
                f"pin{i}",
                "ground" if i == 1 else f"rod{i - 1}",
                f"rod{i}",
                axis=(0, -1, 0),
                origin=mq.Placement((0, 0, 0 if i == 1 else -length)),
                coordinate=f"q{i}",
            )
            for i in links
        ),
        parameters=(m, length, g),
        gravity=(0, 0, -g),
    )


def cart() -> mq.Mechanism:
    """A cart M = 2 on a rail along x with a hanging rod."""
    M, m, length, g = (mq.Parameter(*p) for p in (("M", 2.0), ("m", 1.0), ("l", 1.0), ("g", 9.81)))
    return mq.Mechanism(
        name="cart_pole",
        bodies=(
            mq.Body("ground"),
            mq.Body("cart", mq.particle(M)),
            mq.Body("rod", mq.rod(m, length)),
        ),
        joints=(
            mq.Prismatic("rail", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("pin", "cart", "rod", axis=(0, -1, 0), coordinate="q"),
        ),
        parameters=(M, m, length, g),
        gravity=(0, 0, -g),
    )


def cases() -> Iterator[Case]:
    """The systems of the comparison."""
    yield Case("pendulum", chain(1), np.array([2.0]))
    yield Case("double", chain(2), np.array([0.9, 0.5]))
    yield Case("cart_pole", cart(), np.array([0.0, 2.0]))
    yield Case("five", chain(5), np.array([0.5, 0.1, 0.1, 0.1, 0.1]))
    yield Case("twenty", chain(20), np.full(20, 0.02))
    panda = mq.read_urdf(arm(Path(mq.robot("panda")).read_text(encoding="utf-8")))
    yield Case("panda", panda, panda.neutral() + 0.1, 1.0, 1e-9)  # it falls in chaos soon after


def arm(text: str) -> str:
    """Panda's URDF with locked fingers and no damping, which not every engine's reader knows."""
    text = re.sub(r"<(mimic|dynamics)[^>]*/>", "", text)
    return re.sub(r'(<joint name="panda_finger_joint\d" type=)"prismatic"', r'\1"fixed"', text)


def exact(case: Case) -> np.ndarray:
    """The final state, as exactly as it can be had."""
    if find_spec("heyoka") and case.mechanism.nv <= 5:
        import heyoka

        from mecanique.motion.compile.derive import program_of
        from mecanique.motion.compile.heyoka import system

        machine = heyoka.taylor_adaptive(
            system(program_of(case.mechanism), heyoka),
            case.start.astype(np.longdouble),
            fp_type=np.longdouble,
            compact_mode=True,
        )
        machine.propagate_until(np.longdouble(case.span))
        return np.asarray(machine.state, dtype=float)
    solver = ode(mq.Reference(case.mechanism).rhs()).set_integrator(
        "dop853", rtol=1e-15, atol=1e-15, nsteps=10**6
    )
    result: np.ndarray = solver.set_initial_value(case.start, 0.0).integrate(case.span)
    return result
