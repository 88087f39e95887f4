"""Ask foreign machine code in a process of its own, which it may end or crash."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mecanique.errors import InputError

_PROGRAM = "import sys; from mecanique.verification.foreign.child import work; work(sys.argv[1])"


def ask_in_child(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Return what a function returns in another process, or raise what it raises there."""
    with tempfile.TemporaryDirectory(prefix="mecanique_foreign_") as folder:
        Path(folder, "task").write_bytes(pickle.dumps((function, arguments)))
        ended = subprocess.run(
            [sys.executable, "-c", _PROGRAM, folder],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=False,
        )
        answer = Path(folder, "answer")
        if not answer.exists():
            code = ended.returncode
            how = f"signal {-code}" if code < 0 else f"exit code {code}"
            raise InputError(f"{name} ended its process, with {how}, instead of answering")
        returned = pickle.loads(answer.read_bytes())
    if isinstance(returned, Exception):
        raise returned
    return returned


def work(folder: str) -> None:
    """Do the task in a folder, and write the answer beside it once it is whole."""
    function, arguments = pickle.loads(Path(folder, "task").read_bytes())
    try:
        returned = function(*arguments)
    except Exception as error:
        returned = error
    part = Path(folder, "part")
    part.write_bytes(pickle.dumps(returned))
    part.rename(Path(folder, "answer"))
