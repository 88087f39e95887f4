"""Where a description comes from: the text it was read from, and what is wrong in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

from mecanique.wording import Legible

Severity: TypeAlias = Literal["error", "warning", "info"]


@final
@dataclass(frozen=True, repr=False)
class Finding(Legible):
    """One finding about a URDF text.

    Args:
        code: which rule found it, e.g. "M204".
        severity: "error" is what `read_urdf` refuses when it is strict, "warning" is likely a
            mistake or leaves something out, "info" is read differently by others.
        file: name of the file; "<text>" if there is none.
        line: the line, counted from 1.
        where: the link, joint or other element, e.g. "joint 'knee'".
        message: what is found.
        why: why it matters.
        remedy: how to mend it.
        name: the rule's name in words, e.g. "triangle-inequality".
        stops: whether nothing can be read because of it, strict or not.
    """

    code: str
    severity: Severity
    file: str
    line: int
    where: str
    message: str
    why: str
    remedy: str
    name: str = ""
    stops: bool = False

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.severity} {self.code} {self.sentence}"

    @property
    def _caption(self) -> str:
        return f"{self.severity} {self.code} {self.sentence}"

    @property
    def kind(self) -> str:
        """The rule's name in words, as of any `Cause`."""
        return self.name

    @property
    def text(self) -> str:
        """What is found, as of any `Cause`."""
        return self.message

    @property
    def sentence(self) -> str:
        """Where it is and what is found, e.g. "link 'arm': its mass is -1 kg"."""
        return f"{self.where}: {self.message}" if self.where else self.message


@final
@dataclass(frozen=True)
class Origin:
    """The text that a mechanism was read from.

    Args:
        file: the path of its file, if there is one.
        text: the text as it was read.
        flaws: the errors in it that its equations of motion do without.
        form: its format: "URDF", "MJCF" or "SDF".
        package_path: the folders in which its reader was told to search for models.
    """

    file: str | None
    text: bytes
    flaws: tuple[Finding, ...] = ()
    form: str = "URDF"
    package_path: tuple[str, ...] = ()
