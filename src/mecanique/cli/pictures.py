"""Commands that show: offline pages, live views, line figures, a gallery."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import mecanique as mq
from mecanique.cli.printing import (
    complain,
    heading,
    named_progress,
    say,
    show,
    verdict_table,
    working,
)
from mecanique.cli.reading import Reading, reads_files
from mecanique.cli.words import (
    Coordinates,
    Duration,
    Parameters,
    Samples,
    Seed,
    SystemName,
    Tolerance,
    Velocities,
    choose,
    find_file,
    report_errors,
    simulate_motion,
    start_of,
)
from mecanique.wording import say_count

Page = Annotated[
    Path | None, typer.Option("--output", "-o", help="The page to write; ./SYSTEM.html by default.")
]

__all__ = ["app"]

app = typer.Typer()


@app.command(epilog="Example: mecanique run rigid_bar_pendulum -p l=2 -q q=1")
@report_errors
@reads_files
def run(
    system: SystemName,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    samples: Samples = None,
    seed: Seed = 0,
    rtol: Tolerance = 1e-10,
    output: Page = None,
    *,
    reading: Reading,
) -> None:
    """Derive, verify, simulate, and write an offline page."""
    from mecanique.reference.engine.package import engine_name

    chosen = choose(system, parameters, reading)
    mechanism = chosen.mechanism
    with working("Deriving the equations of motion"):
        equations = mq.derive(mechanism)
        text = str(equations)
    heading(f"Equations of motion of {mechanism.name}")
    say(text)
    with named_progress(f"Comparing with {engine_name()}") as advance:
        verdict = mq.verify(mechanism, samples=samples, seed=seed, progress=advance)
    say("")
    heading("Verdict")
    heading(verdict.summary, "green" if verdict.agrees else "bold red")
    show(verdict_table(verdict))
    for remark in verdict.remarks:
        say(remark)
    motion = simulate_motion(chosen, q, v, duration, rtol)
    say("")
    heading("Motion")
    say(motion.summary())
    path = output or Path(f"{mechanism.name}.html")
    with working(f"Writing {path}"):
        mq.export(motion, path, equations=equations, verdict=verdict)
    say("")
    say(f"Wrote {path}: open it in a browser, no network needed.")
    if not verdict.agrees:
        raise typer.Exit(1)


@app.command(epilog="Example: mecanique export double_pendulum -o chaos.html --duration 20")
@report_errors
@reads_files
def export(
    system: SystemName,
    output: Page = None,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    rtol: Tolerance = 1e-10,
    *,
    reading: Reading,
) -> None:
    """Write a motion as one offline page with its verdict."""
    chosen = choose(system, parameters, reading)
    motion = simulate_motion(chosen, q, v, duration, rtol)
    path = output or Path(f"{chosen.mechanism.name}.html")
    with working(f"Writing {path}"):
        mq.export(motion, path)
    say(f"Wrote {path}")


@app.command(epilog="Example: mecanique view panda")
@report_errors
@reads_files
def view(
    system: SystemName,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="How long to simulate; forever by default."),
    ] = None,
    rtol: Tolerance = 1e-10,
    speed: Annotated[
        float | None,
        typer.Option(
            metavar="NUMBER",
            help="Simulated seconds per second; 1 by default, less for very short motions.",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(metavar="NUMBER", help="Port on this machine; 0 for any free one.")
    ] = 0,
    open_browser: Annotated[
        bool,
        typer.Option(
            "--browser/--no-browser", help="Open the page in a browser, or only print its address."
        ),
    ] = True,
    move: Annotated[
        bool,
        typer.Option(
            "--move",
            help="Simulate a file or robot, too; by default, and without -v, --duration and "
            "--speed, it is shown at rest with its findings and a slider for each joint.",
        ),
    ] = False,
    *,
    reading: Reading,
) -> None:
    """Simulate a system live in a browser, or look into a robot at rest, until Ctrl-C."""
    chosen = choose(system, parameters, reading)
    start, velocity = start_of(chosen, q, v)
    moving = move or v or duration is not None or speed is not None
    if not moving and not mq.textbook.catalogue.is_known(system):
        findings = mq.lint(
            find_file(system),
            package_path=reading.package_path or None,
            arguments=reading.arguments,
        )
        mq.inspect(
            chosen.mechanism, findings, q=start or None, port=port, open_browser=open_browser
        )
        return
    if speed is None:
        speed = 1.0 if chosen.duration > 0.5 else chosen.duration / 10
    mq.view(
        chosen.mechanism,
        q=start,
        v=velocity,
        duration=duration,
        rtol=rtol,
        speed=speed,
        port=port,
        open_browser=open_browser,
    )


@app.command(epilog="Example: mecanique picture cart_pole -o cart_pole.svg --free-body cart")
@report_errors
@reads_files
def picture(
    system: SystemName,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="The file: .svg, .png or .pdf; ./SYSTEM.svg by default."
        ),
    ] = None,
    time: Annotated[
        float | None,
        typer.Option("--time", metavar="SECONDS", help="Draw this instant of the motion."),
    ] = None,
    free_body: Annotated[
        str | None,
        typer.Option(
            "--free-body", metavar="BODY", help="Draw this body cut free, with all forces on it."
        ),
    ] = None,
    resultants: Annotated[
        bool, typer.Option("--resultants", help="Draw each reaction on it as one arrow.")
    ] = False,
    numbers: Annotated[
        bool, typer.Option("--numbers", help="Write the values of the forces on it.")
    ] = False,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    rtol: Tolerance = 1e-10,
    *,
    reading: Reading,
) -> None:
    """Draw a system as a textbook figure, or one body cut free."""
    chosen = choose(system, parameters, reading)
    path = output or Path(f"{chosen.mechanism.name}.svg")
    if time is None and free_body is None and not q and not v:
        from mecanique.figure.posture import posture

        mq.picture(chosen.mechanism, path=path, q=posture(chosen.mechanism, chosen.start).tolist())
    else:
        motion = simulate_motion(chosen, q, v, max(time or 0.0, 0.1), rtol)
        mq.picture(motion, time, path, free_body=free_body, resultants=resultants, numbers=numbers)
    say(f"Wrote {path}")


@app.command(epilog="Example: mecanique gallery pages")
@report_errors
def gallery(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Directory for the pages; created if needed.")
    ],
    systems: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="SYSTEM", help="Only this system; repeatable."),
    ] = None,
    duration: Duration = None,
    only_pictures: Annotated[
        bool, typer.Option("--pictures", help="Write only the pictures, as SVG files.")
    ] = False,
) -> None:
    """Write an offline page for every textbook system, and an index."""
    from mecanique.viewing.gallery import gallery as write
    from mecanique.viewing.gallery import pictures

    if only_pictures:
        say(f"Wrote {len(pictures(directory, systems))} pictures to {directory}")
        return
    with named_progress("Writing pages") as advance:
        cards = write(directory, systems, duration=duration, progress=advance)
    failed = [card for card in cards if card.fault]
    for card in failed:
        complain(f"{card.name}: {card.fault}")
    all_of_them = say_count(len(cards), "system")
    say(f"Wrote {directory / 'index.html'}: {len(cards) - len(failed)} of {all_of_them}")
    if failed:
        raise typer.Exit(1)
