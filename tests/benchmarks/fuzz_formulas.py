"""Judge random texts as formulas: only documented errors, each within five seconds and 300 MB.

    python tests/benchmarks/fuzz_formulas.py [SECONDS] [SEED]

Texts are pieces of real notations in random order, real formulas with signs exchanged, repeated or
left out, and repetitions of one piece up to the largest length that is read. What breaks, a warning
included, is printed with the seed of its text; the exit code is 1 then. Time is the processor's;
memory is the peak of each judgement above what it began with, on Linux.
"""

from __future__ import annotations

import random
import sys
import time
import traceback
import warnings
from pathlib import Path

import mecanique as mq

SYSTEMS = ("simple_pendulum", "double_pendulum", "cart_pole", "rolling_disk", "bead_on_hoop")
ASKED = (
    "equation of motion",
    "kinetic energy",
    "potential energy",
    "Lagrangian",
    "energy",
    "mass matrix",
    "momentum",
    "conserved quantity",
    "frequency",
    "equilibrium",
    "reaction",
)
_WRITTEN = r"""
q x t g l m M R W T V L p H E 0 1 2 3 7 9.81 1/2 1e3 .5 + - * / ^ ** = == ( ) [ ] { } , ; ' '' | <
q' q'' q1 q2 q1' q2'' x'' theta phi phi'' sin cos tan sqrt exp log abs sign atan2 pow asin and pi ½
Eq( Matrix( Rational( Derivative( diff( .diff(t) (t) d/dt d^2q/dt^2 dq/dt ⁻¹ ₁ √ · − ′ q̈ θ̇ λ g/l
\frac \frac{d}{dt} \dfrac{ \ddot{q} \dot q \dot{ \sin \theta_1 \left( \right) \left. \\ & \quad _{1}
\begin{pmatrix} \end{pmatrix} \begin{array}{cc} \end{array} \boxed{ \mathrm{ ^{\prime} [[q,l],[g,m]]
<math> </math> <mi>q</mi> <mo>=</mo> <mfrac> </mfrac> <msup> </msup> &amp;
"""
PIECES = (*_WRITTEN.split(), " ", "  ", "\n", "\t", "\r", "\x00", "\u0307", "\u200b", "\ud800")
FORMULAS = (
    "q'' + g/l sin q = 0",
    "m l^2 q'' = -m g l sin(q)",
    r"\ddot{q} + \frac{g}{l}\sin q = 0",
    "Eq(m*l**2*Derivative(q(t), (t, 2)) + g*l*m*sin(q(t)), 0)",
    "1/2 m l^2 q'^2",
    "m g l (1 - cos q)",
    "sqrt(g/l)",
    "q = 0",
    "[[ (m1+m2) l1^2, m2 l1 l2 cos(q1-q2) ], [m2 l1 l2 cos(q1-q2), m2 l2^2]]",
    "<math><mi>q</mi><mo>=</mo><mfrac><mi>g</mi><mi>l</mi></mfrac></math>",
    "(M + m) x'' + m l q'' cos q - m l q'^2 sin q = F",
    "1) q1'' = q2\n2) q2'' = q1",
)


def write(chance: random.Random) -> str:
    """Return one text."""
    kind = chance.random()
    if kind < 0.45:
        return chance.choice(("", " ")).join(chance.choices(PIECES, k=chance.randint(1, 30)))
    if kind < 0.9:
        signs = list(chance.choice(FORMULAS))
        for _ in range(chance.randint(1, 6)):
            at = chance.randrange(len(signs) + 1)
            act = chance.random()
            if act < 0.4:
                signs[at:at] = chance.choice(PIECES)
            elif act < 0.7:
                del signs[at : at + chance.randint(1, 4)]
            else:
                signs[at:at] = signs[chance.randrange(len(signs) + 1) :][: chance.randint(1, 9)]
        return "".join(signs)
    piece = "".join(chance.choices(PIECES, k=chance.randint(1, 4)))
    many = piece * chance.choice((3, 30, 300, 20_000 // len(piece)))
    return "".join(chance.sample([many, chance.choice(PIECES), chance.choice(FORMULAS)], 3))


def resident(which: str) -> float:
    """Return "VmRSS", the memory in use, or "VmHWM", its peak since the last reset [MB]."""
    status = Path("/proc/self/status")
    if not status.exists():
        return 0.0
    line = next(line for line in status.read_text().splitlines() if line.startswith(which))
    return int(line.split()[1]) / 1024


def reset_peak() -> None:
    """Let the peak of the memory begin anew (proc(5), clear_refs)."""
    refs = Path("/proc/self/clear_refs")
    if refs.exists():
        refs.write_text("5")


def main() -> int:
    """Judge texts until the time is over."""
    warnings.simplefilter("error")
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    mechanisms = [mq.textbook.load(name) for name in SYSTEMS]
    started, slowest, largest, broken = time.monotonic(), (0.0, 0), (0.0, 0), 0
    outcomes: dict[str, int] = {}
    while time.monotonic() < started + seconds:
        chance = random.Random(seed)
        mechanism, text = chance.choice(mechanisms), write(chance)
        ask = chance.choice(ASKED) if chance.random() < 0.5 else ASKED[0]
        let = [f"{chance.choice('abJ')} = {write(chance)}"] if chance.random() < 0.1 else []
        reset_peak()
        start, before = time.process_time(), resident("VmRSS")
        try:
            outcome: str = mq.check(mechanism, text, ask, let).outcome
        except (mq.FormulaError, mq.InputError) as error:
            outcome = type(error).__name__
            str(error)
        except Exception as error:
            outcome = f"BROKEN: {type(error).__name__}"
            broken += 1
            print(f"seed {seed}, {mechanism.name}, {ask}: {text[:200]!r} {let!r:.100}")
            print("  " + "  ".join(traceback.format_exception(error)[-2:]))
        outcomes[outcome] = outcomes.get(outcome, 0) + 1
        slowest = max(slowest, (time.process_time() - start, seed))
        largest = max(largest, (resident("VmHWM") - before, seed))
        seed += 1
    print(outcomes)
    print(
        f"{sum(outcomes.values())} texts, slowest {slowest[0]:.1f} s (seed {slowest[1]}), "
        f"largest {largest[0]:.0f} MB (seed {largest[1]})"
    )
    return bool(broken)


if __name__ == "__main__":
    sys.exit(main())
