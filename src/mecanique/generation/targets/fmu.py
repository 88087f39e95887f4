"""Write an FMU for simulation tools, by the FMI standard 3.0: model exchange and co-simulation."""

from __future__ import annotations

import hashlib
import io
import json
import platform
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from html import escape
from itertools import product as cartesian
from pathlib import Path
from typing import final

from mecanique.derivation.mechanics.switching import ElementRows
from mecanique.derivation.tolerances import SWITCHING
from mecanique.errors import DerivationError, InputError
from mecanique.generation.dop853 import write_constants
from mecanique.generation.program import Answer, Program, ProgramInput, SwitchingTerms
from mecanique.generation.targets.c import (
    SteppedProgram,
    compiler,
    limit_optimization,
    list_numbers,
    write_function,
    write_steps,
)
from mecanique.generation.targets.python import require, say_versions, write_test
from mecanique.generation.targets.target import Cases, run_command
from mecanique.model.mechanism_units import per_second
from mecanique.model.units import read_unit
from mecanique.urdf.markup import quote

SIMULATION_RTOL = 1e-8
"""Default relative tolerance of a simulation."""


@final
@dataclass(frozen=True)
class Variable:
    """A variable of a model; its index among the others is its value reference."""

    name: str
    kind: str  # "time", "state", "rate", "parameter", "input", "output", "margin" or "mode"
    unit: str = ""  # its unit, "" if it has none
    meaning: str = ""  # its meaning, in a few words
    start: float | None = None  # its initial value; None if it is computed
    fixed: bool = False  # whether a parameter must not change during a simulation


def variables_of(program: Program) -> tuple[Variable, ...]:
    """Return the variables of a program to be integrated: time, states, rates, p, outputs."""
    letters, fixed = program.letters, _find_fixed(program)
    states = [*letters["q"], *letters["v"]]
    variables = [Variable("time", "time", "s")]
    for state, value in zip(states, program.start, strict=True):
        variables.append(Variable(state.name, "state", state.unit, start=value))
    for state in states:
        variables.append(Variable(f"der({state.name})", "rate", per_second(state.unit)))
    for letter in letters["p"]:
        kind = "parameter" if letter.name in program.mechanism.values else "input"
        held = letter.place in fixed
        variables.append(
            Variable(
                name=letter.name,
                kind=kind,
                unit=letter.unit,
                meaning=letter.meaning,
                start=letter.value,
                fixed=held,
            )
        )
    for letter in letters["tau"]:
        meaning = "added to the forces of the mechanism"
        variables.append(Variable(letter.name, "input", letter.unit, meaning, 0.0))
    for answer in results_of(program):
        labels = _label(program, answer)
        meaning = answer.quantity.meaning
        variables += [Variable(name, "output", unit, meaning) for name, unit in labels]
    if program.corners is not None:
        elements = program.corners.elements
        for element in elements:
            for what in ("gap or pressure", "friction or slip"):
                name = f"left[{element.name}, {what}]"
                variables.append(Variable(name, "margin", meaning="its state ends at zero"))
        for element in elements:
            meaning = ", ".join(f"{_code(element, state)}: {state}" for state in element.states)
            variables.append(Variable(f"state[{element.name}]", "mode", meaning=meaning))
    names = [variable.name for variable in variables]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DerivationError(f"two variables of the model would be called {twice[0]!r}")
    return tuple(variables)


def results_of(program: Program) -> list[Answer]:
    """Return the answers that are outputs: all except the rates of the state."""
    return [a for a in program.answers if a.quantity.name != "rhs" and not a.quantity.mode]


def _code(element: ElementRows, state: str) -> int:
    """Return the number of a state of an element in C; 1 where it is closed, struck or sticks."""
    if not state:
        return 1
    return element.states.index(state) + (element.normal is None)


def token_of(program: Program) -> str:
    """Return the token that ties the description of a model to its binary."""
    names = [(v.name, v.kind, v.unit, v.start) for v in variables_of(program)]
    text = repr((program.name, names, program.count()))
    return f"{{{hashlib.sha256(text.encode()).hexdigest()[:32]}}}"


def describe_model(program: Program, generator: str) -> str:
    """Return the modelDescription.xml of a program."""
    variables = variables_of(program)
    kinds = ("state", "rate", "output", "margin", "mode")
    places = {kind: _find_places(variables, kind) for kind in kinds}
    first = places["rate"][0] - places["state"][0] if places["state"] else 0
    astray = program.landing is not None or program.corners is not None
    held = 'needsCompletedIntegratorStep="true" ' if astray else ""
    same = (
        f'modelIdentifier={quote(program.name)} canGetAndSetFMUState="true" '
        'canSerializeFMUState="true"'
    )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fmiModelDescription fmiVersion="3.0" modelName={quote(program.mechanism.name)}',
        f'  instantiationToken="{token_of(program)}" generationTool={quote(generator)}',
        '  variableNamingConvention="flat">',
        f"  <ModelExchange {held}{same}/>",
        f'  <CoSimulation {same} canHandleVariableCommunicationStepSize="true"/>',
        *_write_units(variables),
        f'  <DefaultExperiment startTime="0" stopTime="10" tolerance="{SIMULATION_RTOL!r}"/>',
        "  <ModelVariables>",
    ]
    for place, variable in enumerate(variables):
        lines.append(_write_variable(place, variable, first))
    lines += ["  </ModelVariables>", "  <ModelStructure>"]
    shown = sorted([*places["state"], *places["output"], *places["mode"]])
    lines += [f'    <Output valueReference="{k}"/>' for k in shown]
    lines += [f'    <ContinuousStateDerivative valueReference="{k}"/>' for k in places["rate"]]
    unknown = [*places["rate"], *places["output"]]
    unknown += places["mode"]
    lines += [f'    <InitialUnknown valueReference="{k}"/>' for k in unknown]
    lines += [f'    <EventIndicator valueReference="{k}"/>' for k in places["margin"]]
    return "\n".join([*lines, "  </ModelStructure>", "</fmiModelDescription>", ""])


def _write_variable(place: int, variable: Variable, before: int) -> str:
    """Write a variable; `before` is the distance from a state to its rate."""
    how = {
        "time": 'causality="independent" variability="continuous"',
        "state": 'causality="output" variability="continuous" initial="exact"',
        "rate": 'causality="local" variability="continuous" initial="calculated" '
        f'derivative="{place - before}"',
        "parameter": f'causality="parameter" initial="exact" '
        f'variability="{"fixed" if variable.fixed else "tunable"}"',
        "input": 'causality="input" variability="continuous"',
        "output": 'causality="output" variability="continuous" initial="calculated"',
        "margin": 'causality="local" variability="continuous" initial="calculated"',
        "mode": 'causality="output" variability="discrete" initial="calculated"',
    }[variable.kind]
    words = [f"<Float64 name={quote(variable.name)}", f'valueReference="{place}"', how]
    if variable.start is not None:
        words.append(f'start="{variable.start!r}"')
    if variable.unit:
        words.append(f"unit={quote(variable.unit)}")
    if variable.meaning:
        words.append(f"description={quote(variable.meaning)}")
    return f"    {' '.join(words)}/>"


def _write_units(variables: tuple[Variable, ...]) -> Iterator[str]:
    """Yield the units in SI base units; a radian counts as a unit in rad, rad/s and rad/s²."""
    yield "  <UnitDefinitions>"
    for unit in sorted({variable.unit for variable in variables if variable.unit}):
        exponents = dict(zip(("kg", "m", "s", "A", "K"), read_unit(unit), strict=True))
        exponents["rad"] = int(unit in ("rad", "rad/s", "rad/s²"))
        stated = [f'{base}="{power}"' for base, power in exponents.items() if power]
        base = " ".join(["<BaseUnit", *stated])
        yield f"    <Unit name={quote(unit)}>{base}/></Unit>"
    yield "  </UnitDefinitions>"


def _find_places(variables: tuple[Variable, ...], kind: str) -> list[int]:
    return [place for place, variable in enumerate(variables) if variable.kind == kind]


def _find_fixed(program: Program) -> set[str]:
    """Find the inputs on which the closure of loops depends."""
    if program.landing is None:
        return set()
    tape = program.tape
    operations = [tape.operations[k] for k in tape.find_needed(program.landing.gaps)]
    return {name for kind, _, name in operations if kind == "input"}


def _label(program: Program, answer: Answer) -> list[tuple[str, str]]:
    """Return the name and unit of each entry of an answer."""
    quantity = answer.quantity
    if quantity.name == "elements":
        words = quantity.meaning.split(", ")
        return [
            (f"der({before})" if name == "its rate" else name, "")
            for before, name in zip(["", *words], words, strict=False)
        ]
    if quantity.name == "energy":
        return [("kinetic_energy", "J"), ("potential_energy", "J")]
    if quantity.name == "acceleration":
        return [(f"{letter.name}'", letter.unit) for letter in program.letters["a"]]
    if quantity.name == "poses":
        return list(_label_poses(program))
    if quantity.name == "reactions":
        return list(_label_reactions(program))
    forces = quantity.name in ("bias", "gravity", "forces")
    units = [letter.unit for letter in program.letters["tau"]] if forces else []
    units = units or [""] * len(answer.values)
    indices = cartesian(*(range(1, size + 1) for size in answer.shape))
    names = [f"{quantity.name}[{','.join(map(str, index))}]" for index in indices]
    return list(zip(names, units, strict=True))


def _label_poses(program: Program) -> Iterator[tuple[str, str]]:
    mechanism = program.mechanism
    for body in mechanism.bodies:
        if body.name != mechanism.ground:
            for row in range(1, 4):
                for column in range(1, 5):
                    yield f"pose[{body.name},{row},{column}]", "m" if column == 4 else ""


def _label_reactions(program: Program) -> Iterator[tuple[str, str]]:
    mechanism = program.mechanism
    for holder in (*mechanism.joints, *mechanism.loops):
        for part, unit in (("F", "N"), ("M", "N·m")):
            for axis in "xyz":
                yield f"reaction[{holder.name},{part}{axis}]", unit


_OPTIONS = ("-std=c99", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-fno-math-errno")

_MADE = (1980, 1, 1, 0, 0, 0)
"""Date of all files, for identical bytes from identical models."""


def platform_of() -> tuple[str, str]:
    """Return the name of this platform in the FMI standard, and the suffix of its libraries."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system, ending = {
        "linux": ("linux", ".so"),
        "darwin": ("darwin", ".dylib"),
        "win32": ("windows", ".dll"),
    }.get(sys.platform, (sys.platform, ".so"))
    return f"{machine}-{system}", ending


@final
class FMU:
    """A model of the FMI standard: its sources, and a binary for this platform."""

    title = "FMI 3.0"

    def files(self, program: Program, head: Sequence[str]) -> dict[str, str | bytes]:
        """Return the model, with a binary if there is a compiler."""
        name, source = program.name, write_source(program)
        comment = ["/*", *(f" * {line}".rstrip().replace("*/", "* /") for line in head), " */", ""]
        tool = head[2] if len(head) > 2 else "mecanique"
        parts: dict[str, str | bytes] = {
            "modelDescription.xml": describe_model(program, tool.removeprefix("Written by ")),
            f"sources/{name}.c": "\n".join(comment) + source,
            "sources/buildDescription.xml": _BUILD.format(name=name),
            "documentation/index.html": _PAGE.format(
                name=escape(program.mechanism.name), text=escape("\n".join(head))
            ),
        }
        where, ending = platform_of()
        with suppress(InputError):  # without a compiler, the importing tool compiles the sources
            parts[f"binaries/{where}/{name}{ending}"] = _build(name, source)
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for path, content in parts.items():
                archive.writestr(zipfile.ZipInfo(path, _MADE), content, zipfile.ZIP_DEFLATED)
        return {f"{name}.fmu": packed.getvalue()}

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the test with its table."""
        text = write_test(program, cases, _IMPORTS, _COMPARE, f"{program.name}.fmu")
        groups = {answer.quantity.name: len(answer.values) for answer in results_of(program)}
        text = text.replace("GROUPS = {}", f"GROUPS = {groups!r}")
        if program.corners is not None:
            modes = dict(_list_modes(program, program.corners.elements))
            size = len(program.letters["v"]) + len(program.corners.positional)
            text = text.replace("MODES = {}", f"MODES = {modes!r}").replace(
                "SIZE = 0", f"SIZE = {size}"
            )
        return {f"test_{program.name}.py": text}

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the command that runs the test."""
        require("fmpy")
        compiler()
        return [[sys.executable, str(directory / f"test_{program.name}.py")]]

    def version(self) -> str:
        """Return the versions of Python and FMPy."""
        return say_versions("fmpy")


def write_source(program: Program) -> str:
    """Write the C source of a model in one file."""
    letters, corners = program.letters, program.corners
    rates = () if corners is not None else program.answers[0].values
    for answer in program.answers:
        if "a" in answer.quantity.takes:
            raise DerivationError(
                f"{answer.quantity.name!r} is a function of accelerations, which are not inputs of "
                "an FMU; choose other quantities"
            )
    symbols = {"t": "t"}
    for array, group in (("y", ("q", "v")), ("p", ("p", "tau"))):
        places = [letter.place for kind in group for letter in letters[kind]]
        symbols |= {place: f"{array}{k}" for k, place in enumerate(places)}
    moving = SteppedProgram(program.mechanism, program.tape, symbols, rates, program.landing)
    given = [v for v in variables_of(program) if v.kind in ("parameter", "input")]
    change = {"input": "2", "parameter": "0"}
    held = ["1" if v.fixed and v.kind == "parameter" else change[v.kind] for v in given]
    lines = [write_steps(moving), f"#define CORNERS {int(corners is not None)}"]
    lines += (
        ["enum { ELEMENTS = 0 };"] if corners is None else _write_corners(moving, corners, letters)
    )
    firsts, functions = [0], []
    for answer in results_of(program):
        functions.append(f"give_{answer.quantity.name}")
        lines += write_function(moving, functions[-1], answer.values)
        firsts.append(firsts[-1] + len(answer.values))
    if corners is not None:
        functions += ["give_margins", "give_states"]
        firsts += [firsts[-1] + 2 * len(corners.elements), firsts[-1] + 3 * len(corners.elements)]
    values = list_numbers([*(variable.start or 0.0 for variable in given), 0.0])
    lines += [
        f"enum {{ P = {len(given)}, OUTPUTS = {firsts[-1]}, GROUPS = {len(functions)} }};",
        f'static const char TOKEN[] = "{token_of(program)}";',
        f"static const double START[N] = {list_numbers(program.start)};",
        f"static const double GIVEN[P + 1] = {values};",
        f"static const int FIXED[P + 1] = {{{', '.join([*held, '0'])}}};",
        f"static const int first_output[GROUPS + 1] = {{{', '.join(map(str, firsts))}}};",
        *write_constants(["NEAREST"]),
        f"static const double TOLERANCE = {SIMULATION_RTOL!r};",
        "typedef void (*Give)(double, const double *, const double *, double *);",
        f"static const Give output[GROUPS + 1] = {{{', '.join([*functions, 'NULL'])}}};",
        "",
    ]
    return "\n".join(lines) + Path(__file__).with_name("fmu.c").read_text(encoding="utf-8")


def _list_modes(
    program: Program, elements: Sequence[ElementRows]
) -> Iterator[tuple[str, tuple[list[int], int, list[int]]]]:
    """Yield each answer in a mode: its states in C, whether it is an impact, and its places.

    Of an impact the state of the element that is struck is 1.
    """
    velocities = list(range(len(program.letters["v"])))
    for answer in program.answers:
        if named := dict(answer.quantity.mode):
            codes, rows = list[int](), list[int]()
            for element in elements:
                if element.name in named:
                    rows += element.rows
                    codes.append(_code(element, named[element.name]))
                else:
                    codes.append(0)
            places = [*velocities, *(len(velocities) + row for row in rows)]
            yield answer.quantity.name, (codes, int(answer.quantity.struck), places)


def _write_corners(
    moving: SteppedProgram, corners: SwitchingTerms, letters: Mapping[str, Sequence[ProgramInput]]
) -> Iterator[str]:
    """Yield C that finds which mode follows: tables of the elements, their terms, and the law."""
    elements = corners.elements
    tables = {
        "normal": [-1 if e.normal is None else e.normal for e in elements],
        "pressing": [-1 if e.pressing is None else e.pressing for e in elements],
        "struck": [int(e.struck) for e in elements],
        "elastic": [int(e.normal is not None and not e.struck) for e in elements],
        "in_turn": [int(e.in_turn) for e in elements],
        "by_impulse": [int(e.by_impulse) for e in elements],
        "ends": [int(e.length is not None) for e in elements],
        "positional": list(map(int, corners.positional)),
    }
    count = len(letters["p"]) + len(letters["tau"])
    rows = len(corners.positional)
    yield f"enum {{ ELEMENTS = {len(elements)}, ROWS = {rows}, MODE = {count} }};"
    for name, row in tables.items():
        yield f"static const int {name}[] = {{{', '.join(map(str, row))}}};"
    rubbed = (f"{{{', '.join(map(str, (*e.tangents, -1, -1)[:2]))}}}" for e in elements)
    yield f"static const int tangents[][2] = {{{', '.join(rubbed)}}};"
    names = ", ".join(json.dumps(e.name) for e in elements)
    yield f"static const char *const name[] = {{{names}}};"
    for name, number in {"LENGTH": corners.length, **SWITCHING}.items():
        yield f"static const double {name} = {number!r};"
    yield from write_function(moving, "measure", corners.values)
    for k, values in corners.impacts.items():
        yield from write_function(moving, f"collide_{k}", values)
    struck = [f"collide_{k}" if k in corners.impacts else "NULL" for k in range(len(elements))]
    yield "typedef void (*Collide)(double, const double *, const double *, double *);"
    yield f"static const Collide collide[] = {{{', '.join(struck)}}};"
    yield Path(__file__).with_name("corners.c").read_text(encoding="utf-8")


@lru_cache(maxsize=4)  # a model is built twice: to be judged, and then with its verdict
def _build(name: str, source: str) -> bytes:
    """Build the binary for this platform."""
    with tempfile.TemporaryDirectory() as folder:
        # on Windows, gcc adds .exe to a name without suffix
        path, library = (Path(folder) / f"{name}{ending}" for ending in (".c", platform_of()[1]))
        path.write_text(source, encoding="utf-8")
        options = [*_OPTIONS, *limit_optimization([path]), "-o", str(library)]
        command = [compiler(), *options, str(path), "-lm"]
        done = run_command(command)
        if done.returncode:
            raise DerivationError(f"the C compiler refused: {done.stderr.strip()[:2000]}")
        return library.read_bytes()


_BUILD = """<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{name}">
    <SourceFileSet language="C99">
      <SourceFile name="{name}.c"/>
    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""

_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title></head>
<body><pre>{text}</pre></body></html>
"""

_IMPORTS = (
    "import ctypes",
    "import shutil",
    "",
    "from fmpy import extract, read_model_description",
    "from fmpy.fmi1 import FMICallException",
    "from fmpy.fmi3 import FMU3Model, FMU3Slave",
    "",
)

_COMPARE = '''
GROUPS = {}
SIZE = 0  # of what is solved for in a mode
MODES = {}  # of each mode or impact: states of the elements, whether it is one, where to look


def log(environment, status, category, message):
    print(message.decode(), file=sys.stderr)


class Model:
    """One instance, by value references: time, states, rates, p, outputs."""

    def __init__(self, kind, folder, description):
        self.states = len(INPUTS["q"][0]) + len(INPUTS["v"][0])
        self.kind = kind
        part = description.modelExchange if kind is FMU3Model else description.coSimulation
        self.fmu = kind(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=part.modelIdentifier,
            instanceName="test",
        )
        self.fmu.instantiate(logMessage=log)

    def start(self, k, moves=True):
        """Put it in a state, from which it moves."""
        self.y = [*INPUTS["q"][k], *INPUTS["v"][k]]
        given = [*INPUTS["p"][k], *INPUTS["tau"][k]]
        first = 1 + 2 * self.states
        self.fmu.reset()
        self.fmu.setFloat64(range(first, first + len(given)), given)
        self.fmu.setFloat64(range(1, 1 + self.states), self.y)
        self.fmu.enterInitializationMode(startTime=INPUTS["t"][k][0])
        if not moves:
            return
        self.fmu.exitInitializationMode()
        if self.kind is FMU3Model:
            self.put(INPUTS["t"][k][0], np.array(self.y))

    def put(self, t, y):
        self.fmu.setTime(t)
        numbers = (ctypes.c_double * len(y))(*y)
        self.fmu.setContinuousStates(numbers, len(y))

    def solve(self, k, states, strikes, places):
        """Return accelerations and forces in a mode, or velocities and impulses after an impact."""
        y, p, modes = (
            (ctypes.c_double * len(row))(*row)
            for row in (
                [*INPUTS["q"][k], *INPUTS["v"][k]],
                [*INPUTS["p"][k], *(0.0 for _ in INPUTS["tau"][k]), *states],
                states,
            )
        )
        out = (ctypes.c_double * SIZE)()
        solve = self.fmu.dll.mecanique_mode
        solve.argtypes = [ctypes.c_double, *[ctypes.c_void_p] * 3, ctypes.c_int, ctypes.c_void_p]
        solved = solve(INPUTS["t"][k][0], y, p, modes, strikes, out)
        return np.array(out)[places] if solved else np.full(len(places), np.nan)

    def read(self, first, size):
        return np.array(self.fmu.getFloat64(range(first, first + size)))

    def rates(self, t, y):
        self.put(t, y)
        return self.read(1 + self.states, self.states)


def report(name, differences, allowed):
    worst = int(np.argmax(differences))
    print(name, float(differences[worst]), worst)
    failed = 0
    for k, difference in enumerate(differences):
        if not difference <= allowed[k]:
            print(f"{name} differs by {difference:.3g} in state {k}", file=sys.stderr)
            failed = 1
    return failed


def integrate(model, t, y, step, substeps):
    """Integrate by the classical Runge-Kutta method."""
    h = step / substeps
    for i in range(substeps):
        k1 = model.rates(t + i * h, y)
        k2 = model.rates(t + (i + 0.5) * h, y + h / 2 * k1)
        k3 = model.rates(t + (i + 0.5) * h, y + h / 2 * k2)
        k4 = model.rates(t + (i + 1) * h, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y


def distance(y, other):
    return float(np.max(np.abs(y - other) / (1 + np.abs(y))))


def compare_step(model, other, k):
    """Return the difference between a step of co-simulation and one by another method."""
    model.start(k)
    t, y = INPUTS["t"][k][0], np.array(model.y)
    step = 0.05
    while True:
        try:
            coarse, end = (integrate(model, t, y, step, substeps) for substeps in (8, 16))
        except FMICallException:
            coarse = end = np.full(len(y), np.nan)  # so long a step leaves the range of motion
        if distance(coarse, end) < 1e-8:
            break
        if step < 1e-9:
            return None
        step /= 4
    try:
        other.start(k)
        other.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=step)
    except FMICallException:
        return None  # near a position where loops lock
    return distance(other.read(1, model.states), end)


def main():
    folder = extract(str(HERE))
    description = read_model_description(folder)
    states = range(len(INPUTS["t"]))
    model = Model(FMU3Model, folder, description)
    answers = {name: [] for name in EXPECTED}
    for k in states:
        model.start(k, moves=not MODES)
        if "rhs" in answers:
            answers["rhs"].append(model.read(1 + model.states, model.states))
        for name, mode in MODES.items():
            answers[name].append(model.solve(k, *mode))
        at = 1 + 2 * model.states + len(INPUTS["p"][0]) + len(INPUTS["tau"][0])
        for name, size in GROUPS.items():
            answers[name].append(model.read(at, size))
            at += size
    failed = 0
    for name, expected in EXPECTED.items():
        off = np.array(answers[name]) - expected
        failed |= report(name, np.linalg.norm(WEIGHTS[name] * off, axis=1), ALLOWED[name])
    other = Model(FMU3Slave, folder, description)
    if not MODES:
        steps = [compare_step(model, other, k) for k in states[:10]]
        steps = [difference for difference in steps if difference is not None]
        failed |= report("co-simulation", steps or [np.inf], [1e-7] * max(len(steps), 1))
    for instance in (model, other):
        instance.fmu.terminate()
        instance.fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
'''
