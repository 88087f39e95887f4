"""Write the versions of all packages that continuous integration installs.

Usage: python .ci/constrain.py > .ci/constraints.txt, which takes some minutes: everything is
installed anew, at its latest version, into an environment that is thrown away.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXTRAS = "test,docs,lint"
OLDEST = (3, 10)
LIST = """
from importlib.metadata import distributions
for each in distributions():
    print(each.name, each.version, (each.metadata["Requires-Python"] or "").replace(" ", ""))
"""


def main() -> None:
    """Print one line for each package, for the versions of Python that can have it."""
    environment = {key: text for key, text in os.environ.items() if key != "PIP_CONSTRAINT"}
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = str(Path(folder, "Scripts" if os.name == "nt" else "bin", "python"))
        wanted = [f"{ROOT}[{EXTRAS}]", "hatchling"]  # which builds the package
        install = [python, "-m", "pip", "install", "--quiet", *wanted]
        subprocess.run(install, env=environment, check=True, stdout=sys.stderr)
        listed = subprocess.run(
            [python, "-c", LIST], check=True, capture_output=True, encoding="utf-8"
        )
    print("# Written by .ci/constrain.py; what continuous integration installs, and nobody else.")
    for line in sorted(set(listed.stdout.splitlines()), key=str.lower):
        name, version, *needed = line.split(" ")
        if name.lower() not in ("mecanique", "pip", "setuptools"):
            print(f"{name}=={version}{marker(''.join(needed))}")


def marker(needed: str) -> str:
    """Return the marker of a package that the oldest Python cannot have; "" if it can.

    Args:
        needed: its Requires-Python, e.g. ">=3.11".
    """
    bounds = [part[2:] for part in needed.split(",") if part.startswith(">=")]
    least = max((tuple(int(n) for n in bound.split(".")[:2]) for bound in bounds), default=OLDEST)
    return f' ; python_version >= "{least[0]}.{least[1]}"' if least > OLDEST else ""


if __name__ == "__main__":
    main()
