"""Commands that show: offline pages, live views, line figures, a gallery."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.exceptions import Exit

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.printing import (
    complain,
    heading,
    named_progress,
    say,
    show,
    verdict_table,
    working,
)
from mecanique.cli.words import Chosen, find_file, report_errors, simulate_motion, takes_system
from mecanique.files import stem_of
from mecanique.wording import say_count

if TYPE_CHECKING:
    from mecanique.derivation.switching import Modes


@click.command(epilog="Example: mecanique run rigid_bar_pendulum -p l=2 -q q=1")
@options.system
@options.start
@options.duration
@options.samples
@options.seed
@options.tolerance
@options.page
@takes_system
def run(
    chosen: Chosen,
    duration: float | None,
    samples: int | None,
    seed: int,
    rtol: float,
    output: Path | None,
) -> None:
    """Derive, verify, simulate, and write an offline page."""
    from mecanique.reference.engine.package import engine_name

    mechanism = chosen.mechanism
    with working("Deriving the equations of motion"):
        # an element that switches has its equations mode by mode
        equations, said = _derive(mechanism)
    heading(f"Equations of motion of {mechanism.name}")
    say(said)
    with named_progress(f"Comparing with {engine_name()}") as advance:
        verdict = mq.verify(mechanism, samples=samples, seed=seed, progress=advance)
    say("")
    heading("Verdict")
    heading(verdict.summary, "green" if verdict.agrees else "bold red")
    show(verdict_table(verdict))
    for remark in verdict.remarks:
        say(remark)
    motion = simulate_motion(chosen, duration, rtol)
    say("")
    heading("Motion")
    say(motion.summary())
    path = output or Path(f"{stem_of(mechanism.name)}.html")
    with working(f"Writing {path}"):
        mq.export(motion, path, equations=equations, verdict=verdict)
    say("")
    say(f"Wrote {path}: open it in a browser, no network needed.")
    if not verdict.agrees:
        raise Exit(1)


def _derive(mechanism: mq.Mechanism) -> tuple[mq.Equations | Modes | None, str]:
    """Return the equations to show, and their text; None where modes are not written out."""
    if not mechanism.switching:
        equations = mq.derive(mechanism)
        return equations, str(equations)
    from mecanique.derivation.switching import READABLE

    try:
        modes = mq.derive_modes(mechanism, most=READABLE)
    except mq.DerivationError as error:
        return None, f"They are not written out: {error}."
    return modes, str(modes)


@click.command(epilog="Example: mecanique export double_pendulum -o chaos.html --duration 20")
@options.system
@options.page
@options.start
@options.duration
@options.tolerance
@takes_system
def export(chosen: Chosen, output: Path | None, duration: float | None, rtol: float) -> None:
    """Write a motion as one offline page with its verdict."""
    motion = simulate_motion(chosen, duration, rtol)
    path = output or Path(f"{stem_of(chosen.mechanism.name)}.html")
    with working(f"Writing {path}"):
        mq.export(motion, path)
    say(f"Wrote {path}")


@click.command(epilog="Example: mecanique view panda")
@options.system
@options.start
@options.real("--duration", "How long to simulate; endless by default.", metavar="SECONDS")
@options.tolerance
@options.real(
    "--speed",
    "Simulated seconds per second of real time; 1 by default, less for very short motions.",
)
@click.option(
    "--port", default=0, metavar="NUMBER", help="Port on this machine; 0 for any free one."
)
@click.option(
    "--browser/--no-browser",
    "open_browser",
    default=True,
    help="Open the page in a browser, or only print its address.",
)
@click.option(
    "--move",
    is_flag=True,
    help="Simulate a file or a robot. Without this, -v, --duration or --speed, it is shown at "
    "rest with its findings and a slider for each joint.",
)
@takes_system
def view(
    chosen: Chosen,
    duration: float | None,
    rtol: float,
    speed: float | None,
    port: int,
    open_browser: bool,
    move: bool,
) -> None:
    """Show a live motion, or a robot at rest, in a browser.

    Ctrl-C ends it.
    """
    reading = chosen.reading
    moving = move or chosen.v or duration is not None or speed is not None
    if not moving and not mq.textbook.catalogue.is_known(chosen.system):
        findings = mq.lint(
            find_file(chosen.system),
            package_path=reading.package_path or None,
            arguments=reading.arguments,
        )
        start = chosen.start or None
        mq.inspect(chosen.mechanism, findings, q=start, port=port, open_browser=open_browser)
        return
    if speed is None:
        speed = 1.0 if chosen.duration > 0.5 else chosen.duration / 10
    mq.view(
        chosen.mechanism,
        q=chosen.start,
        v=chosen.velocity,
        duration=duration,
        rtol=rtol,
        speed=speed,
        port=port,
        open_browser=open_browser,
    )


@click.command(epilog="Example: mecanique picture cart_pole -o cart_pole.svg --free-body cart")
@options.system
@options.output("The file (.svg, .png or .pdf); ./SYSTEM.svg by default.")
@options.real("--time", "Draw the motion at this time.", metavar="SECONDS")
@click.option("--free-body", metavar="BODY", help="Draw this body cut free, with all forces on it.")
@click.option(
    "--resultants", is_flag=True, help="Draw each reaction as one arrow, with --free-body."
)
@click.option("--numbers", is_flag=True, help="Write the values of the forces, with --free-body.")
@options.start
@options.tolerance
@takes_system
def picture(
    chosen: Chosen,
    output: Path | None,
    time: float | None,
    free_body: str | None,
    resultants: bool,
    numbers: bool,
    rtol: float,
) -> None:
    """Draw a system as a textbook figure, or one body cut free."""
    path = output or Path(f"{stem_of(chosen.mechanism.name)}.svg")
    if time is None and free_body is None and not (chosen.q or chosen.v):
        from mecanique.figure.setting import posture

        mq.picture(chosen.mechanism, path=path, q=posture(chosen.mechanism, chosen.start).tolist())
    else:
        motion = simulate_motion(chosen, max(time or 0.0, 0.1), rtol)
        mq.picture(motion, time, path, free_body=free_body, resultants=resultants, numbers=numbers)
    say(f"Wrote {path}")


@click.command(epilog="Example: mecanique gallery pages")
@click.argument(
    "directory",
    type=options.PATH,
    metavar="DIR",
    help="Directory for the pages; created if needed.",
)
@options.several("--only", "systems", said="Only this system; repeatable.", metavar="SYSTEM")
@options.duration
@click.option("--pictures", "only_pictures", is_flag=True, help="Write only the pictures, as SVG.")
@report_errors
def gallery(
    directory: Path, systems: tuple[str, ...], duration: float | None, only_pictures: bool
) -> None:
    """Write a page for every textbook system, and an index."""
    from mecanique.viewing.gallery import gallery as write
    from mecanique.viewing.gallery import pictures

    if only_pictures:
        say(f"Wrote {len(pictures(directory, systems or None))} pictures to {directory}")
        return
    with named_progress("Writing pages") as advance:
        cards = write(directory, systems or None, duration=duration, progress=advance)
    failed = [card for card in cards if card.fault]
    for card in failed:
        complain(f"{card.name}: {card.fault}")
    all_of_them = say_count(len(cards), "system")
    say(f"Wrote {directory / 'index.html'}: {len(cards) - len(failed)} of {all_of_them}")
    if failed:
        raise Exit(1)
