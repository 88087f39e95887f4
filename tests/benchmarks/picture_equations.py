"""Pictures of the compiled equations of nine systems, from this version or from any other.

Run by hand: python tests/benchmarks/picture_equations.py FOLDER [SOURCE]. SOURCE is the directory
`src` of the version that derives, e.g. of a worktree of an earlier commit; this one by default.
One picture is the first page of all steps by all methods, compiled as far as that goes, another
the equations alone. Needs pdflatex and pdftoppm.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SYSTEMS = (
    "rigid_bar_pendulum",
    "two_blocks",
    "double_pendulum",
    "cart_pole",
    "foucault_pendulum",
    "crane",
    "bars_and_springs",
    "slider_crank",
    "gyroscope",
)
PREAMBLE = r"""\documentclass[a4paper]{article}
\usepackage[utf8]{inputenc}
\usepackage{amsmath}
\setlength{\parindent}{0pt}
\begin{document}
"""
OWN = Path(__file__).parents[2] / "src"


def derive(source: Path, *options: str) -> str:
    """What `mecanique derive` of a version prints in LaTeX."""
    command = [sys.executable, "-m", "mecanique", "derive", *options, "--format", "latex"]
    environment = {**os.environ, "PYTHONPATH": str(source)}
    done = subprocess.run(command, env=environment, capture_output=True, check=True)
    return done.stdout.decode("utf-8").strip()


def draw(folder: Path, name: str, text: str) -> int:
    """Compile a fragment, draw its first page, and return how many errors pdflatex found."""
    (folder / f"{name}.tex").write_text(PREAMBLE + text + "\\end{document}\n", encoding="utf-8")
    compile_ = ["pdflatex", "-interaction=nonstopmode", f"{name}.tex"]
    done = subprocess.run(compile_, cwd=folder, capture_output=True, check=False)
    page = ["pdftoppm", "-png", "-singlefile", "-r", "90", f"{name}.pdf", name]
    subprocess.run(page, cwd=folder, check=False)
    return done.stdout.decode("utf-8", "replace").count("\n! ")


def main(folder: Path, source: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name in SYSTEMS:
        alone = derive(source, name)
        if alone.startswith("\\begin{aligned}"):  # as earlier versions print them
            alone = f"\\[\n{alone}\n\\]\n"
        steps = derive(source, name, "--steps", "--method", "all")
        errors = draw(folder, name, alone), draw(folder, f"{name}_steps", steps)
        print(f"{name:20} errors: equations {errors[0]}, steps {errors[1]}", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else OWN)
