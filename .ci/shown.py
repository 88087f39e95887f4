"""Run what README and the documentation show, in the environment that this Python belongs to.

Usage: python .ci/shown.py FILE.md …: the commands of each file's `sh` blocks, in a folder of its
own, and README's tour in Python. What README installs, tests and builds, `.ci/run` does itself; a
tutorial that needs an extra installs it in its block.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
OF_README = ("pip ", "pytest", "sphinx-build ")
SECONDS = 300
"""What one command may take."""


def run(file: Path) -> None:
    """Run the blocks of a file, and raise CalledProcessError where one fails."""
    tour, commands = "", list[str]()
    for kind, text in BLOCK.findall(file.read_text(encoding="utf-8")):
        if kind == "sh":
            commands += [part.strip() for line in text.splitlines() for part in line.split("&&")]
        elif file.name == "README.md":
            tour += text
    if file.name == "README.md":
        commands = [command for command in commands if not command.startswith(OF_README)]
    environment = dict(os.environ)
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), environment["PATH"]])
    with tempfile.TemporaryDirectory() as folder:
        if tour:
            commands.insert(0, f"python {file.name}.py")
            Path(folder, f"{file.name}.py").write_text(tour, encoding="utf-8")
        for command in commands:
            print(f"{file.name}: {command}", flush=True)
            # the commands are shown to somebody in a clone of the repository
            there = re.sub(r"^pip install ('?)\.", rf"pip install --quiet \1{ROOT}", command)
            subprocess.run(
                there,
                shell=True,
                cwd=folder,
                env=environment,
                check=True,
                timeout=SECONDS,
                stdout=subprocess.DEVNULL,
            )


if __name__ == "__main__":
    for name in sys.argv[1:]:
        run(Path(name))
