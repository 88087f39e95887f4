"""Other programs in Pinocchio's place: compiled functions, FMUs, JAX and CasADi."""

from __future__ import annotations

import ctypes
import re
import runpy
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.generation.targets.c import compiler
from mecanique.verification import foreign
from mecanique.verification.states import random_states

HEADER = """
enum { crane_nq = %d };
void crane_acceleration(double t, const double *q, const double *v, const double *tau,
                        const double *p, double *out); /* a */
void crane_mass_matrix(const double *q, double *out);
"""


def build(folder: Path, text: str) -> Path:
    (folder / "lib.c").write_text(text, encoding="utf-8")
    command = [compiler(), "-shared", "-fPIC", "-o", str(folder / "lib.so"), str(folder / "lib.c")]
    subprocess.run([*command, "-lm"], check=True)
    return folder / "lib.so"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The cart-pole's code, compiled."""
    folder = tmp_path_factory.mktemp("library")
    what = "acceleration,mass_matrix,bias,gravity,forces,inverse_dynamics,energy"
    code = mq.generate(mq.derive(mq.textbook.load("cart_pole")), "c", what, samples=2)
    code.write(folder)
    return build(folder, (folder / "cart_pole.c").read_text(encoding="utf-8"))


def test_a_library_agrees_and_a_heavier_cart_does_not(library: Path) -> None:
    header = library.with_name("cart_pole.h")
    cart = mq.textbook.load("cart_pole")
    verdict = mq.verify(cart, against=library, header=header)
    assert verdict.agrees
    assert {row.quantity for row in verdict.rows} >= {"acceleration", "mass matrix", "bias"}
    heavier = cart.replace(m=1.5 * cart.values["m"])
    other = mq.verify(heavier, samples=5, against=library, header=header)
    assert not other.agrees
    assert other.causes


def test_functions_of_ctypes_and_cffi_stand_in(library: Path) -> None:
    cart = mq.textbook.load("cart_pole")
    function = ctypes.CDLL(str(library)).cart_pole_acceleration
    assert mq.verify(cart, samples=5, against=function).agrees
    assert mq.verify(cart, samples=5, against={"acceleration": function}).agrees
    wrong = mq.textbook.load("double_pendulum")
    assert not mq.verify(wrong, samples=5, against={"acceleration": function}).agrees
    with pytest.raises(mq.InputError, match="expected 1 numbers from acceleration, it wrote 2"):
        mq.verify(mq.textbook.load("simple_pendulum"), against={"acceleration": function})
    idle = ctypes.CFUNCTYPE(None)(lambda: None)
    with pytest.raises(mq.InputError, match=r"acceleration, it wrote 0$"):
        mq.verify(cart, samples=1, against={"acceleration": idle})
    ffi = pytest.importorskip("cffi").FFI()
    ffi.cdef("void cart_pole_bias(double, double *, double *, double *, double *);")
    bias = ffi.dlopen(str(library)).cart_pole_bias
    assert mq.verify(cart, samples=5, against={"bias": bias}).agrees


def test_what_a_header_says_wrongly_is_refused(tmp_path: Path) -> None:
    path = build(tmp_path, "void crane_mass_matrix(const double *q, double *out) { out[0] = *q; }")
    crane, header = mq.textbook.load("crane"), tmp_path / "lib.h"
    size = crane.nq
    for text, message in (
        (HEADER % (size + 1), rf"expected nq = {size} \(.*\) in .*, it states {size + 1}"),
        (HEADER % size, "lib.h declares crane_acceleration, which .* does not have"),
        ("void f(double *out);", "whose names end in _acceleration, .*; it declares f"),
        ("void a_bias(double *x, double *out);", "arguments of a_bias among t, q, v, .*got x, out"),
        ("void a_bias(double q, double *out);", "expected q of a_bias to be a pointer"),
        ("void a_bias(float *q, float *out);", "expected arguments of a_bias in double precision"),
        ("void a_mass_matrix(double *q, double *out);", "declares a_mass_matrix, which"),
    ):
        header.write_text(text, encoding="utf-8")
        with pytest.raises(mq.InputError, match=message):
            mq.verify(crane, against=path, header=header)
    header.write_text("void crane_mass_matrix(const double *q, double *out);", encoding="utf-8")
    written = rf"expected {crane.nv**2} numbers from crane_mass_matrix, it wrote 1"
    with pytest.raises(mq.InputError, match=written):
        mq.verify(crane, against=path, header=header)
    with pytest.raises(mq.InputError, match=r"expected the header of .*lib.so, which says what"):
        mq.verify(crane, against=path)
    with pytest.raises(mq.InputError, match=r"expected a C header, but .* cannot be read"):
        mq.verify(crane, against=path, header=tmp_path / "none.h")
    with pytest.raises(mq.InputError, match="expected a shared library with a header"):
        mq.verify(crane, against=crane, header=header)
    (tmp_path / "text.so").write_text("no library", encoding="utf-8")
    with pytest.raises(mq.InputError, match=r"expected a shared library, but .* does not load"):
        mq.verify(crane, against=tmp_path / "text.so", header=header)


def test_a_header_states_both_sizes_and_a_library_holds_its_own_parameters(library: Path) -> None:
    body, header = mq.textbook.load("free_rigid_body"), library.with_name("body.h")
    for nq, nv, message in (
        (7, 6, "expected a shared library, but .* does not load"),
        (6, 6, r"expected nq = 7 \(.*\) in .*, it states 6"),
        (7, 7, r"expected nv = 6 \(.*\) in .*, it states 7"),
    ):
        text = f"enum {{ m_nq = {nq}, m_nv = {nv} }};\nvoid m_bias(const double *q, double *out);"
        header.write_text(text, encoding="utf-8")
        with pytest.raises(mq.InputError, match=message):
            foreign.load_library(library.with_name("none.so"), header, body)
    cart = mq.textbook.load("cart_pole")
    functions = foreign.load_library(library, library.with_name("cart_pole.h"), cart)
    loaded = ctypes.CDLL(str(library))
    for what, function in functions.items():
        assert function.name == f"cart_pole_{what}"
        named = ctypes.cast(getattr(loaded, function.name), ctypes.c_void_p)
        assert function.address == named.value
        assert foreign.address_of(getattr(loaded, function.name)) == function.address
        own = ctypes.c_double.in_dll(loaded, "cart_pole_parameters")
        assert function.parameters == ctypes.addressof(own)


def test_functions_of_casadi_stand_in(tmp_path: Path) -> None:
    casadi = pytest.importorskip("casadi")
    cart = mq.textbook.load("cart_pole")
    code = mq.generate(mq.derive(cart), "casadi", "acceleration,mass_matrix,energy", samples=2)
    made = runpy.run_path(str(code.write(tmp_path)[0]))
    assert mq.verify(cart, samples=5, against=made["acceleration"]).agrees
    three = {name: made[name] for name in ("acceleration", "mass_matrix", "energy")}
    assert mq.verify(cart, samples=5, against=three).agrees
    with pytest.raises(mq.InputError, match="expected 1 numbers for q of acceleration, the fun"):
        mq.verify(mq.textbook.load("simple_pendulum"), against=made["acceleration"])
    q = casadi.SX.sym("q", 2)
    named = casadi.Function("f", [q], [q], ["q"], ["out"])
    with pytest.raises(mq.InputError, match=r"called after what it gives .*, got 'f'; say what"):
        mq.verify(cart, against=named)


@pytest.mark.slow
def test_functions_of_jax_stand_in(tmp_path: Path) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    cart = mq.textbook.load("cart_pole")
    code = mq.generate(mq.derive(cart), "jax", "acceleration", samples=2)
    made = runpy.run_path(str(code.write(tmp_path)[0]))
    assert mq.verify(cart, samples=3, against=jax.jit(made["acceleration"])).agrees


def test_arguments_are_known_by_their_names() -> None:
    cart = mq.textbook.load("cart_pole")
    reference = mq.Reference(cart)

    def bias(v: np.ndarray, q: np.ndarray, t: float) -> np.ndarray:
        return np.asarray(reference.bias(q, v, t))

    assert mq.verify(cart, samples=5, against=bias).agrees
    with pytest.raises(mq.InputError, match="expected a mechanism, functions or a path to comp"):
        mq.verify(cart, against=3.0)  # type: ignore[arg-type]


def test_an_fmu_stands_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("fmpy")
    pendulum = mq.textbook.load("simple_pendulum")
    code = mq.generate(mq.derive(pendulum), "fmu", samples=2)
    path = code.write(tmp_path)[0]
    verdict = mq.verify(pendulum, samples=10, against=path)
    assert verdict.agrees
    assert {row.quantity for row in verdict.rows} >= {"acceleration", "kinetic energy"}
    # in this process, where a model that fails would end it
    states, (m, l, g) = random_states(pendulum, 3, 0), (pendulum.values[x] for x in "mlg")
    answers = foreign._run_file(path, pendulum, states)
    np.testing.assert_allclose(
        answers["acceleration"], -g / l * np.sin(states.q), rtol=1e-12, atol=0
    )
    kinetic = m * l**2 * states.v[:, 0] ** 2 / 2
    np.testing.assert_allclose(answers["kinetic energy"], kinetic, rtol=1e-12, atol=0)
    lighter = pendulum.replace(g=2.0)
    assert not mq.verify(lighter, samples=10, against=path).agrees
    with pytest.raises(mq.InputError, match=r"expected the states .* in the FMU, got .*; it lacks"):
        mq.verify(mq.textbook.load("cart_pole"), against=path)
    (tmp_path / "text.fmu").write_text("none", encoding="utf-8")
    with pytest.raises(mq.InputError, match=r"expected an FMU, but .* cannot be read"):
        mq.verify(pendulum, against=tmp_path / "text.fmu")
    monkeypatch.setattr("mecanique.verification.foreign.find_spec", lambda _: None)
    with pytest.raises(mq.InputError, match="expected fmpy, which is not installed"):
        mq.verify(pendulum, against=path)


@pytest.mark.parametrize(
    ("does", "message"),
    [
        ("exit(0);", "lib.so ended its process, with exit code 0, instead of answering"),
        ("*(volatile int *)0 = 1;", "lib.so ended its process, with signal 11, instead of"),
    ],
)
def test_a_library_that_ends_its_process_does_not_agree(
    tmp_path: Path, does: str, message: str
) -> None:
    declared = "void crane_acceleration(double t, const double *q, const double *v, double *out)"
    library = build(tmp_path, f"#include <stdlib.h>\n{declared} {{ {does} }}\n")
    header = tmp_path / "lib.h"
    header.write_text(f"{declared};\n", encoding="utf-8")
    with pytest.raises(mq.InputError, match=message):
        mq.verify(mq.textbook.load("cart_pole"), samples=2, against=library, header=header)


def test_arguments_of_declared_functions_are_numbers_or_pointers() -> None:
    takes = foreign._takes
    assert takes("m_bias", "const double *q, const double v[], double *out") == ("q", "v")
    assert takes("m_forces", "double t, const double* q, double out[]") == ("t", "q")
    for arguments, said in {
        "double q, double *out": "expected q of m_bias to be a pointer",
        "const double *t, double *out": "expected t of m_bias to be a number",
        "const double *q, double out": "expected out of m_bias to be a pointer",
        "const float *q, float *out": "expected arguments of m_bias in double precision",
        "const double *x, double *out": "expected arguments of m_bias among t, q, v",
    }.items():
        with pytest.raises(mq.InputError, match=re.escape(said)):
            takes("m_bias", arguments)
