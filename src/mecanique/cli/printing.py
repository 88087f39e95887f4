"""Print data to standard output, everything else to standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.status import Status
    from rich.table import Table

    from mecanique.verification.verdict import Verdict


def say(text: str) -> None:
    """Print text as it is."""
    click.echo(text)


def to_json(data: object) -> str:
    """Return data as JSON text."""
    return json.dumps(data, ensure_ascii=False, indent=2, allow_nan=False)


def heading(text: str, style: str = "bold") -> None:
    """Print a heading."""
    from rich.text import Text

    _console().print(Text(text, style=style), soft_wrap=True)


def show(table: Table) -> None:
    """Print a table."""
    _console().print(table)


def complain(text: str) -> None:
    """Print an error to standard error."""
    click.secho("error: ", fg="red", bold=True, err=True, nl=False)
    click.echo(text, err=True)


def inform(text: str) -> None:
    """Print a remark to standard error."""
    click.echo(text, err=True)


def working(text: str) -> AbstractContextManager[Status]:
    """Return a context that shows a status on a terminal."""
    from rich.console import Console

    return Console(stderr=True).status(f"{text} …")


@contextmanager
def progress(text: str) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on a terminal; yield a function that takes the fraction done."""
    with named_progress(text) as advance:
        yield lambda done: advance("", done)


@contextmanager
def named_progress(text: str) -> Iterator[Callable[[str, float], None]]:
    """Show a progress bar on a terminal; yield a function of the item and the fraction done."""
    if not sys.stderr.isatty():
        yield lambda _name, _done: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(text, total=1.0)

        def advance(name: str, done: float) -> None:
            bar.update(task, completed=done, description=f"{text}: {name}" if name else text)

        yield advance


def verdict_table(verdict: Verdict) -> Table:
    """Return a verdict as a table."""
    from rich.table import Table
    from rich.text import Text

    head, *lines = verdict.table
    table = Table(box=None, pad_edge=False)
    for column in head:
        table.add_column(column, overflow="fold")
    for line in lines:
        table.add_row(
            *(Text(cell, style="bold red" if cell.endswith("!") else "") for cell in line)
        )
    return table


def _console() -> Console:
    from rich.console import Console

    return Console(highlight=False)
