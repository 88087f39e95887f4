"""docs/transcripts.md: a class sheet graded, and the agents' server asked by the official client.

After a change: python tests/serving/transcripts.py
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from mecanique.teaching import grade

PAGE = Path(__file__).parents[2] / "docs" / "transcripts.md"

SHEET = """\
title = "Sheet 3: pendulums"

[[question]]
id = "1a"
system = "rigid_bar_pendulum"
points = 2
form = 0.5            # part of the points for what is right except for form

[[question]]
id = "1b"
system = "rigid_bar_pendulum"
ask = "frequency"
points = 1

[[question]]
id = "1c"
system = "rigid_bar_pendulum"
ask = "equilibrium of rod"
points = 1
let = ["N = R_pin_n"]

[[question]]
id = "2"
system = "cart_pole"
points = 4
"""

CART = "(M + m) x'' + m l cos q q'' - m l sin q q'^2 + c x' = F"
POLE = "cos q x'' + l q'' + g sin q = 0"
ANSWERS = {
    "anna": {
        "1a.tex": r"\ddot{q} = -\frac{3 g}{2 l} \sin q",
        "1b.txt": "T = 2 pi sqrt(2 l/(3 g))",
        "1c.txt": "N - m g cos q = m l/2 q'^2",
        "2.txt": f"{POLE}\n{CART}",
    },
    "ben": {
        "1a.txt": "m l^2/3 q'' + m g l/2 q = 0",
        "1b.txt": "omega = sqrt(g/l)",
        "1c.txt": "N = m g cos q",
        "2.txt": f"{CART}\n{POLE.replace('+ g', '- g')}",
    },
    "cleo": {
        "1a.txt": "m l^2/12 q'' + m g l/2 sin q = 0",
        "1b.txt": "omega = sqrt(3 g/2 l)",
        "1c.txt": "N = m g cos q - m l/2 q'^2",
        "2.txt": CART.replace("(M + m)", "M"),
    },
    "dora": {"1a.txt": "J q'' + m g l/2 sin q = 0", "2.txt": "(M + m x'' = F"},
}

CALLS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("list_systems", {"tag": "rolling"}),
    ("describe", {"system": "rigid_bar_pendulum"}),
    ("derive", {"system": "rigid_bar_pendulum"}),
    (
        "check",
        {"system": "rigid_bar_pendulum", "formula": "m l^2/12 q'' + m g l/2 sin q = 0"},
    ),
    ("check", {"system": "rigid_bar_pendulum", "formula": "__import__('os').system('ls')"}),
    ("simulate", {"system": "rigid_bar_pendulum", "duration": 1.0, "instants": 3}),
    ("describe", {"system": "rigid_bar_pendulm"}),
)


def grade_class() -> str:
    """Return what `mecanique grade` prints for the class."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "sheet.toml").write_text(SHEET, encoding="utf-8")
        for student, texts in ANSWERS.items():
            (place / "answers" / student).mkdir(parents=True)
            for name, text in texts.items():
                (place / "answers" / student / name).write_text(text, encoding="utf-8")
        return str(grade(place / "sheet.toml", place / "answers"))


async def ask_server() -> str:
    """Return what the official client is told, over standard input and output."""
    from mcp import Client, StdioServerParameters

    command = StdioServerParameters(
        command=sys.executable, args=["-m", "mecanique", "agents"], env=dict(os.environ)
    )
    lines = []
    async with Client(command) as client:
        listed = await client.list_tools()
        lines.append(f"list_tools() → {', '.join(tool.name for tool in listed.tools)}")
        for name, arguments in CALLS:
            found = await client.call_tool(name, arguments)
            texts = [part.text for part in found.content if part.type == "text"]
            told = "\n".join(map(_shorten, texts))
            mark = "error: " if found.is_error else ""
            lines += ["", f"{name}({json.dumps(arguments, ensure_ascii=False)})", f"→ {mark}{told}"]
    return "\n".join(lines)


def _shorten(text: str) -> str:
    """Return plain data in lines of readable length, with numbers of four digits."""
    try:
        data = json.loads(text, parse_float=lambda number: float(f"{float(number):.4g}"))
    except ValueError:
        return text
    return "\n".join(
        line if len(line) <= 160 else f"{line[:157]}…"
        for line in json.dumps(data, ensure_ascii=False, indent=1).splitlines()
    )


def page(graded: str, served: str) -> str:
    """Return docs/transcripts.md."""
    answers = "\n".join(
        f"answers/{student}/{name}\n" + "\n".join(f"    {line}" for line in text.splitlines())
        for student, texts in ANSWERS.items()
        for name, text in texts.items()
    )
    parts = [
        "# Transcripts",
        "Written by `python tests/serving/transcripts.py`; tests run both again.",
        "## A class sheet graded",
        f"`sheet.toml`:\n\n```toml\n{SHEET.rstrip()}\n```",
        f"What the students handed in:\n\n```text\n{answers}\n```",
        f"`mecanique grade sheet.toml answers`:\n\n```text\n{graded}\n```",
        "## The server for agents, asked by the official client",
        "The Python client of the Model Context Protocol's own package (`mcp`) starts `mecanique "
        "agents`\nand speaks with it over standard input and output. What "
        "cannot be answered is\nrefused in words that a program can act on.",
        f"```text\n{served}\n```",
    ]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(grade_class(), asyncio.run(ask_server())), encoding="utf-8")
