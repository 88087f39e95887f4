"""Expand a xacro file with the library of that name (extra `xacro`).

Its own search for packages is replaced by that of meshes: the folders given, ROS_PACKAGE_PATH,
AMENT_PREFIX_PATH and the packages around the file. It works in a process of its own, which ends
itself: the expressions of a file are Python's, and neither a signal nor a thread interrupts one.
"""

from __future__ import annotations

import atexit
import faulthandler
import math
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from itertools import count
from pathlib import Path
from threading import Lock
from typing import Any, final
from xml.dom import minidom

from mecanique.errors import InputError, MecaniqueError, UnknownNameError
from mecanique.plugins import new_interpreter
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.parse import MOST_BYTES, parse
from mecanique.urdf.reading.packages import MeshSearch
from mecanique.wording import say_count

_MARK = "mecanique_place"
_MOST_CALLS = 10_000
"""How often macros may be called: forty that call the next one twice are so 10¹² times."""
_SECONDS, _GIBIBYTES = 60.0, 4
"""In what time [s] and memory a file is expanded; Windows and macOS do not bound the memory."""
_LOCK = Lock()
_ARGUMENT = re.compile(r"\$\(arg\s+([^\s)]+)\s*\)")
_UNKNOWN = re.compile(r"unknown macro name: (\S+)")
_PARAMETERS = re.compile(r"(Undefined parameters|Invalid parameter) \W(\w+)")


@final
@dataclass
class XacroLines:
    """File and line of every element that xacro may copy, and what the files ask for."""

    known: list[tuple[str, int]] = field(default_factory=list)  # file and line by number
    taken: list[int | None] = field(default_factory=list)  # None for an element of xacro's own
    written: dict[str, tuple[str, int]] = field(default_factory=dict)  # by text to be evaluated
    asked: dict[str, tuple[str, int]] = field(default_factory=dict)  # by name of the argument
    defaults: set[str] = field(default_factory=set)  # arguments that have one
    macros: list[str] = field(default_factory=list)
    calls: list[Element] = field(default_factory=list)  # the elements of xacro's own

    def mark(self, text: bytes, file: str) -> bytes:
        """Return a text with a number in each element; as it is, if it cannot be read."""
        root = parse(text, Report(file))
        try:
            text.decode("utf-8")  # offsets count its bytes
        except UnicodeDecodeError:
            root = None
        if root is None:
            return text
        pieces, before = list[bytes](), 0
        for element in root.walk():
            self._note(element, file)
            if element.tag.startswith("xacro:"):
                continue
            at = element.offset + 1 + len(element.tag.encode())
            pieces += [text[before:at], f' {_MARK}="{len(self.known)}"'.encode()]
            self.known.append((file, element.line))
            before = at
        return b"".join([*pieces, text[before:]])

    def _note(self, element: Element, file: str) -> None:
        place, given = (file, element.line), element.attributes
        for text in (*given.values(), element.text):
            if "$" in text:
                self.written.setdefault(text, place)
                for name in _ARGUMENT.findall(text):
                    self.asked.setdefault(name, place)
        name = given.get("name", "")
        if element.tag.startswith("xacro:"):
            self.calls.append(replace(element, file=file))
        if element.tag == "xacro:include":
            self.written.setdefault(given.get("filename", ""), place)
        if element.tag == "xacro:arg":
            self.asked.setdefault(name, place)
            if "default" in given:
                self.defaults.add(name)
        elif element.tag == "xacro:macro":
            self.macros.append(name)

    def find_call(self, said: str, macro: str) -> tuple[str, int] | None:
        """Return the file and line of the call that xacro refuses, if it refuses one."""
        unknown, parameter = _UNKNOWN.match(said), _PARAMETERS.match(said)
        tag = unknown[1] if unknown else f"xacro:{macro}"
        for call in self.calls if unknown or parameter else ():
            given = parameter is None or parameter[2] in call.attributes
            if call.tag == tag and given == (parameter is None or parameter[1][0] == "I"):
                return call.file, call.line
        return None

    def take(self, document: Any) -> None:
        """Take the numbers out of an expanded document."""
        self.taken.clear()
        for node in _elements(document.documentElement):
            number = node.getAttribute(_MARK)
            self.taken.append(int(number) if number else None)
            if number:
                node.removeAttribute(_MARK)

    def put(self, root: Element) -> Element:
        """Return the elements of an expanded text with files and lines of those who wrote them."""
        if sum(1 for _ in root.walk()) != len(self.taken):
            return root
        return self._put(root, iter(self.taken), ("", root.line))

    def _put(
        self, element: Element, numbers: Iterator[int | None], above: tuple[str, int]
    ) -> Element:
        number = next(numbers)
        file, line = above if number is None else self.known[number]
        children = tuple(self._put(child, numbers, (file, line)) for child in element.children)
        return replace(element, children=children, file=file, line=line)


def _elements(node: Any) -> Iterator[Any]:
    waiting = [node]
    while waiting:
        element = waiting.pop()
        yield element
        inner = [child for child in element.childNodes if child.nodeType == child.ELEMENT_NODE]
        waiting.extend(reversed(inner))


Letters = Mapping[str, float]
"""Values of arguments and properties instead of those written, by name."""


@final
class XacroValues:
    """The arguments and properties of a xacro file, noted while it is expanded."""

    def __init__(self, given: Mapping[str, str], letters: Letters) -> None:
        self._given = frozenset(given)
        self._letters = letters
        texts = {name: repr(value) for name, value in letters.items()}
        self.arguments = _Asked({**given, **texts})
        self._tables: list[tuple[str, Any]] = []
        self._written: dict[tuple[int, str], str] = {}
        self._redefined: set[str] = set()

    def define(self, element: Any, table: Any, define: Callable[[Any, Any], None]) -> None:
        """Define a property, with another value if it is a letter."""
        name = element.getAttribute("name")
        if name in self._letters and not element.hasAttribute("remove"):
            if element.hasAttribute("default"):
                element.removeAttribute("default")
            element.setAttribute("value", repr(self._letters[name]))
        # as it is written: to compute it already would fix what it is computed from
        text = element.getAttribute("value")
        if self._written.setdefault((id(table), name), text) != text:
            self._redefined.add(name)
        define(element, table)
        self._tables.append((name, table))

    def refuse_unknown(self) -> None:
        """Refuse an argument that the expanded file never asked for."""
        for name in sorted(self._given - self.arguments.asked):
            raise UnknownNameError("argument", name, sorted(self.arguments.asked))

    def numbers(self) -> dict[str, float | str]:
        """Return the number of each name, or in words why it has none.

        An argument and a property of one name are one letter if they have one value.
        """
        texts: dict[str, list[object]] = {name: [text] for name, text in self.arguments.items()}
        if self._tables:  # noted by the library, which a plain URDF does without
            from xacro import substitution_args_context

            substitution_args_context["arg"] = self.arguments
            for name, table in self._tables:
                try:
                    value = table[name]
                except Exception:
                    continue  # a block, or what can be computed inside of a macro only
                texts.setdefault(name, []).append(value)
            substitution_args_context["arg"] = {}
        numbers = {name: _number(values) for name, values in texts.items()}
        return numbers | dict.fromkeys(self._redefined, "is defined more than once")


@final
class _Asked(dict[str, str]):
    """Arguments by name, to which the library adds defaults, and the names it asked for."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def _number(values: Collection[object]) -> float | str:
    """Return the number that all values are; in words what they are if there is none."""
    numbers = set[float]()
    for value in values:
        number = _read(value)
        if number is None:
            return f"is no number but {repr(value)[:60]}"
        numbers.add(number)
    if len(numbers) == 1:
        return numbers.pop()
    return f"has several values: {', '.join(f'{x:g}' for x in sorted(numbers))}"


def _read(value: object) -> float | None:
    if isinstance(value, bool) or (isinstance(value, str) and "_" in value):
        return None
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None


@cache
def _start(owner: int) -> subprocess.Popen[bytes]:
    """Start the process that expands the files of a process, which shares none with its forks."""
    command = new_interpreter("from mecanique.urdf.reading.xacro import serve; serve()")
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    atexit.register(process.__exit__, None, None, None)
    return process


def _ask(*request: object) -> Any:
    """Return the answer to a request; raise an EOFError if the process ends instead."""
    with _LOCK:
        process = _start(os.getpid())
        assert process.stdin, "it is a pipe"
        assert process.stdout, "it is a pipe"
        try:
            pickle.dump(request, process.stdin)
            process.stdin.flush()
            return pickle.load(process.stdout)
        except BaseException:  # an answer that comes later would be another's
            _start.cache_clear()
            with suppress(OSError), process:
                process.kill()
            raise


def serve() -> None:
    """Expand the files that standard input asks for."""
    answers, sys.stdout = sys.stdout.buffer, sys.stderr
    with suppress(ImportError, ValueError, OSError):  # Windows has no such module
        bounds: Any = import_module("resource")
        whole = bounds.getrlimit(bounds.RLIMIT_AS)[1]
        bounds.setrlimit(bounds.RLIMIT_AS, (_GIBIBYTES * 2**30, whole))
    with suppress(EOFError, KeyboardInterrupt), open(os.devnull, "w", encoding="utf-8") as nowhere:
        while True:
            seconds, folder, environment, name, *given = pickle.load(sys.stdin.buffer)
            faulthandler.dump_traceback_later(seconds, exit=True, file=nowhere)
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(environment)
            answer = _answer(name, *given)
            faulthandler.cancel_dump_traceback_later()
            pickle.dump(answer, answers)
            answers.flush()


def _answer(
    name: str, given: Mapping[str, str], letters: Letters | None, search: MeshSearch
) -> object:
    """Return what `expand` asks for: text, places, numbers and findings; or what to raise."""
    report, values = Report(name), XacroValues(given, letters or {})
    try:
        text, places = _expand(Path(name), values, search, report) or (None, None)
        numbers = {} if text is None or letters is None else values.numbers()
        return text, places, numbers, report.findings
    except MecaniqueError as error:
        return error


Numbers = Mapping[str, float | str]
"""The number of each argument and property, or in words why it has none."""


def expand(
    file: Path,
    arguments: Mapping[str, str],
    letters: Letters | None,
    search: MeshSearch,
    report: Report,
) -> tuple[bytes | None, XacroLines | None, Numbers]:
    """Return a xacro file as URDF, its elements' places and, for letters, its numbers.

    What is impossible is reported.
    """
    asked = str(file), dict(arguments), letters, search
    try:
        if sys.platform == "emscripten":  # the page of a browser, which starts no process
            answer = _answer(*asked)
        else:
            answer = _ask(_SECONDS, os.getcwd(), dict(os.environ), *asked)
    except (EOFError, BrokenPipeError):
        said = f"xacro does not expand it within {_SECONDS:g} s and {_GIBIBYTES} GiB of memory"
        remedy = "Its expressions are programs; mend what runs so long."
        report.add("M006", 1, said, remedy)
        return None, None, {}
    except OSError as error:
        report.add("M006", 1, f"xacro needs a process of its own: {error.strerror or error}")
        return None, None, {}
    if isinstance(answer, MecaniqueError):
        raise answer
    text, places, numbers, findings = answer
    report.findings += findings
    return text, places, numbers


def choose(numbers: Numbers, wanted: Collection[str]) -> tuple[dict[str, float], list[str]]:
    """Return the values of those names that are the file's, and all that can be letters."""
    for name in sorted(wanted):
        if isinstance(why := numbers.get(name), str):
            raise InputError(f"{name!r} of the xacro file cannot be a letter: it {why}")
    known = {name: value for name, value in numbers.items() if isinstance(value, float)}
    return {name: known[name] for name in sorted(wanted & known.keys())}, sorted(known)


def _expand(
    file: Path, values: XacroValues, search: MeshSearch, report: Report
) -> tuple[bytes, XacroLines] | None:
    """Return a xacro file as URDF and its elements' places; None if impossible, as reported."""
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        remedy = "pip install 'mecanique[xacro]', or expand it: xacro FILE.xacro > FILE.urdf."
        report.add("M006", 1, "it is a xacro file, and xacro is not installed", remedy)
        return None

    lost: list[str] = []

    def find(package: str) -> str:
        folder = search.package(package)
        if folder is None:
            lost.append(f"package {package!r} is not found in {search.searched}")
            raise LookupError(lost[-1])
        return str(folder)

    places = XacroLines()

    def read(inp: Any, filename: str | None = None) -> Any:
        """Parse what xacro asks for, with a number in each element."""
        if inp is not None or filename is None:
            return plainly(inp, filename)
        path = file.parent / filename
        try:
            text = path.read_bytes()
        except OSError:
            return plainly(inp, filename)
        shown = path
        with suppress(ValueError):
            shown = file.parent / path.resolve().relative_to(file.parent.resolve())
        return minidom.parseString(places.mark(text, str(shown)))

    def define(element: Any, table: Any) -> None:
        values.define(element, table, grab)

    last = [""]  # what is being evaluated

    def evaluate(text: str, *given: Any) -> Any:
        last[0] = text if text in places.written else last[0]  # it calls itself for parts
        return evaluated(text, *given)

    calls = count(1)

    def expand_one(node: Any, *given: Any) -> Any:
        if node.tagName.startswith("xacro:") and next(calls) > _MOST_CALLS:
            raise InputError(f"macros are called more than {_MOST_CALLS:,} times")
        return called(node, *given)

    kept, plainly, grab = substitution_args._eval_find, xacro.parse, xacro.grab_property
    evaluated, called = xacro.eval_text, xacro.handle_macro_call
    substitution_args._eval_find, xacro.parse, xacro.grab_property = find, read, define
    xacro.eval_text, xacro.handle_macro_call = evaluate, expand_one
    try:
        xacro.init_stacks(str(file))
        xacro._global_symbols = xacro.create_global_symbols()  # a file may have changed them
        document = xacro.parse(None, str(file))
        xacro.process_doc(document, mappings=values.arguments)
        places.take(document)
        text = bytes(document.toprettyxml(indent="  ", encoding="utf-8")[: MOST_BYTES + 1])
    except Exception as error:
        # the library evaluates what stands in the file, and lets any error through
        said = " ".join(str(error).split()).rstrip(".") or type(error).__name__
        if isinstance(error, RecursionError):
            said = "a macro or a file asks for itself"
        elif isinstance(getattr(error, "exc", None) or error, MemoryError):
            said = f"it takes more than {_GIBIBYTES} GiB of memory"
        remedy = "Mend it, or give its arguments (--arg NAME=VALUE)."
        name, line = places.written.get(last[0], (str(file), 1))
        callers = [m.body.getAttribute("name") for m in getattr(error, "macros", ())]
        call = places.find_call(said, callers[0] if callers else "")
        missing = [n for n in places.asked if n not in {*values.arguments, *places.defaults}]
        if lost:
            said = lost[-1]
            remedy = "Add its folder to --package-path, ROS_PACKAGE_PATH or AMENT_PREFIX_PATH."
        elif call is not None:
            name, line = call
            remedy = "Correct the call, or the macro's definition."
        elif missing:
            name, line = places.asked[missing[0]]
            said = f"{say_count(len(missing), 'argument')} without a value: {', '.join(missing)}"
            remedy = f"Give {' '.join(f'--arg {name}=VALUE' for name in missing)}."
        at = Element("", {}, (), "", line, 0, name)
        report.add("M006", at, f"xacro does not expand it: {said}", remedy)
        return None
    finally:
        substitution_args._eval_find, xacro.parse, xacro.grab_property = kept, plainly, grab
        xacro.eval_text, xacro.handle_macro_call = evaluated, called
    if places.macros and sum(1 for _ in _elements(document.documentElement)) == 1:
        said = f"it defines macros alone ({', '.join(places.macros)}) and calls none"
        report.add("M006", 1, said, "Name a file that calls them.")
        return None
    values.refuse_unknown()
    return text, places
