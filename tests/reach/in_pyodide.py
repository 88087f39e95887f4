"""Import, in Pyodide without NumPy, SciPy and SymPy, what needs none of them.

Run by `in_pyodide.mjs` after the archive of the documentation's page is unpacked.
"""

from __future__ import annotations

import importlib
import sys
import warnings
from pathlib import Path

ABSENT = {
    "numpy", "scipy", "sympy", "matplotlib", "click", "rich", "pinocchio", "tornado", "meshcat",
}  # fmt: skip
"""What neither the archive nor Pyodide's core has."""

root = Path("mecanique")
modules = sorted(root.rglob("*.py"))
imported = 0
with warnings.catch_warnings():
    warnings.simplefilter("error")  # of the compiler as well, whose Python is newer than ours
    for path in modules:
        compile(path.read_text(encoding="utf-8"), str(path), "exec", dont_inherit=True)
        name = ".".join(path.with_suffix("").parts).removesuffix(".__init__")
        if name.endswith("__main__"):
            continue
        try:
            importlib.import_module(name)
            imported += 1
        except ModuleNotFoundError as error:
            if str(error.name).partition(".")[0] not in ABSENT:
                raise

from mecanique.program.sweeps import pull_back  # noqa: E402
from mecanique.program.tape import Tape  # noqa: E402
from mecanique.safe_xml import tree_of  # noqa: E402

assert tree_of("<robot name='arm'/>").get("name") == "arm"
tape = Tape()
x = tape.input("x")
assert pull_back(tape, [tape.multiply(x, x)], [1.0], [x]) == [tape.add(x, x)]
assert sys.platform == "emscripten"
print(f"{len(modules)} compiled, {imported} imported")
