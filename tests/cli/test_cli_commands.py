"""Every command on real input: what it prints, what it writes, how it ends."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import mecanique as mq
from mecanique.cli import app, main
from mecanique.cli.derive import judge
from mecanique.reference.engine.package import MISSING, has_pinocchio
from mecanique.verification import compare as sources

IN_HOUSE = sources.derive_all


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(app, words)


def fine(*words: str) -> str:
    result = call(*words)
    assert result.exit_code == 0, result.output + repr(result.exception)
    return result.stdout


@pytest.mark.parametrize(("given", "used"), [(None, "1"), ("3", "3")])
def test_blas_has_one_thread_unless_the_user_wants_more(
    given: str | None, used: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given or "")
    if given is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    monkeypatch.setattr("gc.set_threshold", lambda *_: None)
    monkeypatch.setattr("sys.argv", ["mecanique", "--version"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert os.environ["OPENBLAS_NUM_THREADS"] == used


def test_list_names_every_system() -> None:
    lines = fine("list").splitlines()
    assert [line.split()[0] for line in lines] == sorted(
        (*mq.textbook.names(), *mq.textbook.names(corners=True))
    )
    data = json.loads(fine("list", "--json"))
    assert [row["name"] for row in data] == sorted(
        (*mq.textbook.names(), *mq.textbook.names(corners=True))
    )
    pendulum = next(row for row in data if row["name"] == "rigid_bar_pendulum")
    assert pendulum["parameters"]["g"] == {"value": 9.81, "unit": "m/s²"}


def test_derive_prints_the_equations_in_three_forms() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    assert "q'' + 3 g sin(q)/(2 l) = 0" in fine("derive", "rigid_bar_pendulum")
    latex = fine("derive", "rigid_bar_pendulum", "--format", "latex")
    assert latex.strip() == mq.derive(mechanism).latex(symbols=True).strip()
    mathml = fine("derive", "rigid_bar_pendulum", "--format", "mathml")
    assert "<math" in mathml
    assert "mass of the rod [kg]" in mathml


def test_derive_prints_a_complete_latex_file() -> None:
    text = fine("derive", "rigid_bar_pendulum", "--document")
    assert text.startswith("\\documentclass")
    assert text.rstrip().endswith("\\end{document}")
    assert "Kinetic energy" in text
    places = [
        text.index(part)
        for part in ("\\LARGE Rigid bar pendulum", "\\section*", "\\begin{picture}")
    ]
    assert places == sorted(places)
    assert "\\makebox(0,0){" in text
    assert "Verdict" not in text
    assert "align*" not in text
    (motion,) = re.findall(r"Equations of motion}.*?begin{align}(.*?)end{align}", text, re.DOTALL)
    assert "\\nonumber" not in motion


def test_a_document_of_what_switches_writes_each_mode_and_when_it_holds() -> None:
    text = fine("derive", "stick_slip", "--document")
    order = [
        "\\section*{Stick slip: equations of motion",
        "Source: ",
        "\\begin{picture}",
        "$m$}] mass",
    ]
    assert [*map(text.index, order)] == sorted(map(text.index, order))
    titles = re.findall(r"\\subsection\*{(.*?)}", text)
    assert titles == ["belt sticks", "belt slips +", "belt slips -"]
    assert "$\\mu_{0}$}] coefficient of static friction [1]" in text
    assert "sticks if $\\left|\\frac{k x}{m g}\\right| \\leq \\mu_{0}$" in text
    assert "while $\\dot{x} - v > 0$" in text
    plain = fine("derive", "stick_slip")
    assert plain.index("Source: ") < plain.index("\n  mu_0") < plain.index("\nbelt sticks:\n")
    refused = call("derive", "stick_slip", "--method", "all")
    assert refused.exit_code == 2
    assert "expected no other option than -p, --format latex and --document" in refused.output


def test_a_document_of_all_methods_says_everything_once() -> None:
    text = fine("derive", "rigid_bar_pendulum", "--document", "--method", "all")
    assert text.count("hangs from a pin at its upper end") == 1
    assert text.count("mass of the rod [kg]") == 1
    assert text.count("\\section*") == 3
    assert text.count("\\begin{picture}") == 2  # of the system, and of its bar cut free
    # what the system is, its figure, the letters in it, the bodies cut free, the steps
    order = ["A homogeneous rod", "\\begin{picture}", "length of the rod", "\\subsection*"]
    assert [*map(text.index, order)] == sorted(map(text.index, order))
    assert text.index("length of the rod") < text.rindex("\\begin{picture}")
    assert text.rindex("\\begin{picture}") < text.index("\\subsection*")
    verdict = text[text.index("\\subsection*{Verdict}") :]
    rows = [row for row in verdict.splitlines() if row.startswith("acceleration")]
    assert len(rows) == 1
    sizes = [float(x) for x in re.findall(r"10\^\{(-\d+)\}", rows[0])]
    assert max(sizes, default=-16) <= -13
    assert "all agree" in verdict


def test_tables_of_a_verdict_have_no_empty_rows() -> None:
    """Of a loop in independent coordinates only accelerations are compared."""
    rows = re.findall(
        r"^[a-z ]+ (&.*?)(?: \\\\)?$", judge(mq.textbook.load("slider_crank")), re.MULTILINE
    )
    assert len(rows) > 10
    assert all(re.search(r"[0-9]", row) for row in rows)


@pytest.mark.parametrize("form", ["text", "latex", "mathml"])
def test_derive_shows_the_steps(form: str) -> None:
    plain = fine("derive", "two_blocks", "--format", form)
    steps = fine("derive", "two_blocks", "--format", form, "--steps")
    assert len(steps) > 1.5 * len(plain)


def test_verify_prints_the_verdict_and_ends_with_zero() -> None:
    text = fine("verify", "cart_pole", "--samples", "5", "--seed", "3")
    said = text if has_pinocchio() else text.removeprefix(f"{MISSING}\n")
    assert said.startswith("cart_pole: agrees at 5 random states (seed 3)")
    data = json.loads(fine("verify", "cart_pole", "--samples", "5", "--seed", "3", "--json"))
    assert data["agrees"] is True
    assert (data["samples"], data["seed"]) == (5, 3)


@pytest.mark.parametrize("words", [(), ("--json",)])
def test_verify_ends_with_one_if_the_two_disagree(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "derive_all", lambda mechanism: IN_HOUSE(mechanism.replace(l=1.1)))
    result = call("verify", "cart_pole", "--samples", "5", *words)
    assert result.exit_code == 1
    assert ("DISAGREES" in result.stdout) or json.loads(result.stdout)["agrees"] is False


def test_urdf_prints_or_writes_a_file_that_reads_back() -> None:
    text = fine("urdf", "cart_pole", "-p", "l=0.25")
    assert text == mq.write_urdf(mq.textbook.load("cart_pole", l=0.25))
    assert fine("urdf", "cart_pole", "-p", "l=0.25", "-o", "cart.urdf") == "Wrote cart.urdf\n"
    assert Path("cart.urdf").read_text(encoding="utf-8") == text
    assert "agrees" in fine("verify", "cart.urdf", "--samples", "5")


def test_convert_tells_what_of_a_urdf_is_in_no_mechanism(tmp_path: Path) -> None:
    urdf, shape = tmp_path / "arm.urdf", "<geometry><box size='1 1 1'/></geometry>"
    inertia = "<mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
    urdf.write_text(
        f"""<robot name="arm"><link name="base"/>
<link name="arm"><inertial>{inertia}</inertial>
<collision>{shape}</collision><collision>{shape}</collision></link>
<joint name="j" type="continuous">
<parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>
<transmission name="t"><joint name="j"/></transmission></robot>""",
        encoding="utf-8",
    )
    result = CliRunner().invoke(app, ["convert", str(urdf), "-o", str(tmp_path / "arm.xml")])
    assert result.exit_code == 0, result.output
    without = "<collision> (2, first on line 3), <transmission> (1, first on line 6)"
    assert f"Read from URDF, without {without}." in result.output


def test_simulate_prints_a_summary_and_writes_the_motion() -> None:
    words = (
        "simulate",
        "cart_pole",
        "-q",
        "q=0.5",
        "-v",
        "x=0.25",
        "-v",
        "q'=1",
        "--duration",
        "0.5",
    )
    assert "cart_pole" in fine(*words)
    data = json.loads(
        fine(*words, "--json", "--csv", "cart.csv", "--npz", "cart.npz", "--rtol", "1e-9")
    )
    motion = mq.simulate(
        mq.textbook.load("cart_pole"), q={"q": 0.5}, v={"x": 0.25, "q": 1}, duration=0.5, rtol=1e-9
    )
    assert data["end"] == {name: motion[name][-1] for name in ("x", "q", "x'", "q'")}
    assert all(row["ok"] for row in data["audit"].values())
    saved = mq.Motion.load("cart.npz")
    np.testing.assert_array_equal(saved.q, motion.q)
    assert len(Path("cart.csv").read_text(encoding="utf-8").splitlines()) >= len(motion.t)


def test_simulate_starts_as_the_catalogue_says() -> None:
    data = json.loads(fine("simulate", "rigid_bar_pendulum", "--json", "--duration", "0.1"))
    assert 1.9 < data["end"]["q"] < 2.0
    whole = json.loads(fine("simulate", "rigid_bar_pendulum", "--json"))
    assert whole["duration"] == mq.textbook.entry("rigid_bar_pendulum").duration


def test_export_writes_one_page() -> None:
    assert (
        fine("export", "rigid_bar_pendulum", "--duration", "0.2")
        == "Wrote rigid_bar_pendulum.html\n"
    )
    page = Path("rigid_bar_pendulum.html").read_text(encoding="utf-8")
    assert page.lower().startswith("<!doctype html>")
    assert (
        fine("export", "rigid_bar_pendulum", "--duration", "0.2", "-o", "other.html")
        == "Wrote other.html\n"
    )
    assert Path("other.html").is_file()


def test_run_does_everything() -> None:
    text = fine(
        "run", "rigid_bar_pendulum", "--duration", "0.5", "--samples", "5", "-p", "l=2", "-q", "q=1"
    )
    assert "q'' + 3 g sin(q)/(2 l) = 0" in text
    assert "rigid_bar_pendulum: agrees at 5 random states" in text
    assert "mass matrix" in text
    assert "energy" in text
    assert "rigid_bar_pendulum.html" in text
    assert Path("rigid_bar_pendulum.html").is_file()


def test_run_takes_a_urdf_file_and_ends_with_one_on_disagreement(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mq.write_urdf(mq.textbook.load("cart_pole"), "cart.urdf")
    words = (
        "run",
        "cart.urdf",
        "--duration",
        "0.2",
        "--samples",
        "5",
        "-q",
        "pin=1",
        "-o",
        "page.html",
    )
    assert "agrees" in fine(*words)
    monkeypatch.setattr(
        sources, "derive_all", lambda mechanism: IN_HOUSE(mq.textbook.load("cart_pole", m=1.5))
    )
    result = call(*words)
    assert result.exit_code == 1
    assert "DISAGREES" in result.stdout
    assert Path("page.html").is_file()


@pytest.fixture
def viewed(monkeypatch: pytest.MonkeyPatch) -> list[tuple[mq.Mechanism, dict[str, Any]]]:
    """What `mecanique view` hands over, instead of a browser."""
    shown: list[tuple[mq.Mechanism, dict[str, Any]]] = []
    monkeypatch.setattr(mq, "view", lambda mechanism, **options: shown.append((mechanism, options)))
    return shown


def test_view_shows_a_system_without_end_unless_told(
    viewed: list[tuple[mq.Mechanism, dict[str, Any]]],
) -> None:
    fine(
        "view",
        "rigid_bar_pendulum",
        "--duration",
        "0.5",
        "-q",
        "q=1",
        "-v",
        "q'=2",
        "-p",
        "l=2",
        "--speed",
        "0.5",
    )
    fine("view", "cart_pole", "--no-browser", "--port", "8123")
    fine("view", "squeezer")
    (pendulum, options), (_, defaults), (_, brief) = viewed
    assert {each.symbol: each.value for each in pendulum.parameters}["l"] == 2.0
    assert (options["q"], options["v"]) == ({"q": 1.0}, {"q": 2.0})
    assert (options["duration"], options["speed"], options["open_browser"]) == (0.5, 0.5, True)
    assert defaults["q"] == mq.textbook.entry("cart_pole").start
    assert (defaults["duration"], defaults["port"], defaults["open_browser"]) == (None, 8123, False)
    # a motion of 0.03 s is shown in ten
    assert (defaults["speed"], brief["speed"]) == (1.0, 0.003)


def test_derive_prints_all_methods_in_textbook_order_with_every_step() -> None:
    out = fine("derive", "rigid_bar_pendulum", "--method", "all")
    titles = (
        "Newton and Euler's equations",
        "d'Alembert's principle and virtual work",
        "Lagrange's equations",
    )
    places = [out.index(f"Rigid bar pendulum: {title}") for title in titles]
    assert places == sorted(places)
    assert out.count("q'' + 3 g sin(q)/(2 l) = 0") == 3
    assert "All three methods give the same equations of motion" in out
    pages = fine("derive", "two_blocks", "--method", "all", "--format", "mathml")
    assert pages.count("<h3>") == 3
    words = ("derive", "two_blocks", "--method", "newton_euler", "--format", "latex", "--steps")
    assert "\\section*" in fine(*words)


def test_list_shows_degrees_of_freedom_and_takes_tags() -> None:
    lines = fine("list", "--tag", "loop", "--tag", "planar").splitlines()
    assert lines
    assert all("loop" in line and "planar" in line for line in lines)
    four_bar = next(line for line in lines if line.startswith("four_bar_linkage "))
    assert "Crank, coupler and rocker" in four_bar
    assert "N = 1" in four_bar
    data = {
        row["name"]: row["N"] for row in json.loads(fine("list", "--json", "--tag", "pendulum"))
    }
    assert data["double_pendulum"] == 2
    result = call("list", "--tag", "pendulun")
    assert result.exit_code == 2
    assert "pendulum" in result.stderr


def test_picture_draws_a_figure_and_a_body_cut_free() -> None:
    assert fine("picture", "cart_pole", "-p", "l=0.5") == "Wrote cart_pole.svg\n"
    whole = Path("cart_pole.svg").read_text(encoding="utf-8")
    assert whole.startswith("<svg")
    fine(
        "picture",
        "cart_pole",
        "-o",
        "cart.svg",
        "--free-body",
        "cart",
        "--time",
        "0.2",
        "-q",
        "q=0.5",
    )
    assert "forces on cart" in Path("cart.svg").read_text(encoding="utf-8")
    assert call("picture", "cart_pole", "-o", "cart.gif").exit_code == 2


def test_gallery_writes_pages_and_pictures() -> None:
    words = ("gallery", "pages", "--only", "two_blocks", "--duration", "0.1")
    assert fine(*words) == f"Wrote {Path('pages') / 'index.html'}: 1 of 1 system\n"
    assert sorted(path.name for path in Path("pages").iterdir()) == [
        "index.html",
        "two_blocks.html",
    ]
    assert (
        fine("gallery", "drawn", "--only", "two_blocks", "--pictures")
        == "Wrote 1 pictures to drawn\n"
    )
    assert [path.name for path in Path("drawn").iterdir()] == ["two_blocks.svg"]


def test_view_frees_the_root_of_a_robot_or_a_file(
    viewed: list[tuple[mq.Mechanism, dict[str, Any]]],
) -> None:
    mq.write_urdf(mq.textbook.load("cart_pole"), "cart.urdf")
    fine("view", "ur5_robot", "--floating", "--move")
    fine("view", "cart.urdf", "--floating", "--duration", "1")
    fine("view", "cart.urdf", "-q", "pin=1", "--speed", "1")
    robot, loose, held = (mechanism for mechanism, _ in viewed)
    assert "root_joint_z" in robot.coordinates
    assert "root_joint_z" in loose.coordinates
    assert "root_joint_z" not in held.coordinates


def test_view_looks_into_a_file_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[Any, ...]] = []
    monkeypatch.setattr(
        mq,
        "inspect",
        lambda mechanism, findings, **options: seen.append((mechanism, findings, options)),
    )
    mq.write_urdf(mq.textbook.load("cart_pole"), "cart.urdf")
    fine("view", "cart.urdf", "-q", "pin=1", "--floating", "--port", "8123", "--no-browser")
    fine("view", "panda")
    (cart, plain, options), (panda, findings, _) = seen
    assert "root_joint_z" in cart.coordinates
    assert {finding.code for finding in plain} == {f.code for f in mq.lint("cart.urdf")}
    assert options == {"q": {"pin": 1.0}, "port": 8123, "open_browser": False}
    assert panda.name == "panda"
    assert {finding.code for finding in findings} == {f.code for f in mq.lint(mq.robot("panda"))}


def test_view_refuses_what_no_view_can_have() -> None:
    for words, message in (
        (("--speed", "0"), "expected a speed above 0, got 0.0"),
        (("--port", "70000"), "port of a live view: expected 0 to 65535, got 70000"),
        (("--duration", "-1"), "expected a duration above 0, or None for no end, got -1.0"),
    ):
        result = call("view", "rigid_bar_pendulum", "--no-browser", *words)
        assert (result.exit_code, result.stdout) == (2, "")
        assert message in result.stderr


@pytest.mark.parametrize("words", [(), ("--method", "all"), ("--units",)])
def test_equations_that_are_too_long_to_be_read_are_listed_as_results(
    monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    """Those of a quadruped, free in space, were 475,000 characters."""
    monkeypatch.setattr("mecanique.derivation.equations.MOST_TERMS", 3)
    run = CliRunner().invoke(app, ["derive", "double_pendulum", *words])
    assert run.exit_code == 0
    equations = mq.derive(mq.textbook.load("double_pendulum"))
    assert run.stdout.rstrip("\n") == mq.write_recursion(equations).text()
    assert f"The equations have {equations.terms} terms: here they are a list" in run.stderr


@pytest.mark.parametrize(
    "system", ["kepler_orbit", "rigid_bar_pendulum", "rolling_disk", "slider_crank"]
)
def test_what_all_derivations_state_stands_once(system: str) -> None:
    """Only the equations that each arrives at are repeated; the result stands at the end."""
    text = fine("derive", system, "--method", "all")
    parts = re.split(r"^\d+\. ", text, flags=re.MULTILINE)[1:]
    lines = [
        (part.splitlines()[0], *(x for x in part.splitlines() if x.startswith("     ")))
        for part in parts
    ]
    titles = [title for title, *_ in lines]
    # the work on a loop leads to its single equation at once
    assert titles.count("Equations of motion") == (2 if system == "slider_crank" else 3)
    others = [each for each in lines if each[0] != "Equations of motion" and len(each) > 1]
    assert len(set(others)) == len(others)
    assert titles.count("Moments of inertia") == (system != "kepler_orbit")  # of a particle
    # the balances of a bar that is cut free give its pin's force, too
    assert titles.count("Result") == (2 if system == "rigid_bar_pendulum" else 1)
    assert "Result" in titles[-3:]


def test_the_list_of_one_method_stands_for_those_of_all() -> None:
    run = CliRunner().invoke(app, ["derive", "bricard_linkage", "--method", "all"])
    assert run.exit_code == 0
    assert "as long: --method newton_euler or virtual_work writes one" in run.stderr


def test_derive_solves_what_rolls() -> None:
    """The last line of a book: Goldstein, Classical Mechanics, sect. 2.4, with a disk."""
    for words in (("--solve",), ("--in", "x"), ("--in", "turn")):
        solved = fine("derive", "rolling_disk", *words)
        assert "x'' = 2 g sin(alpha)/3\n" in solved
        assert "lambda_contact_x = -m g sin(alpha)/3\n" in solved
        assert "radius of the disk" in solved
    coin = fine("derive", "rolling_coin", "--in", "yaw,lean,spin")
    assert "yaw'' = -2 lean' spin'/cos(lean)" in coin
    assert ". Result\n" in fine("derive", "rolling_disk", "--solve", "--steps")
    page = fine("derive", "rolling_disk", "--solve", "--format", "latex")
    assert "\\ddot{x} &= \\frac{2 g}{3} \\sin \\alpha" in page
    assert "J theta'' + C theta'^2" in fine("derive", "slider_crank", "--in", "theta")
    assert "lambda_link1_l = " in fine("derive", "governor", "--solve")


def test_derive_takes_absolute_angles() -> None:
    said = fine("derive", "four_bar_linkage", "--absolute", "theta=chi", "--in", "phi")
    assert "K_psi = a sin(phi - chi)/(c sin(psi - chi))" in said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("rolling_disk", "--in", "x,turn"), "leave 1 of 3 velocities free, got x, turn to keep"),
        (("double_pendulum", "--in", "q1"), "without constraints it has 2 of 2 velocities free"),
        (("governor", "--in", "s"), "leave 2 of 4 velocities free, got s to keep; psi and s can"),
        (("whipple_bicycle", "--solve"), "solved in numbers, by acceleration(q, v, t), and as a"),
        (("four_bar_linkage", "--absolute", "psi"), "expected NAME=LETTER, got 'psi'"),
        (("cart_pole", "--in", "z"), "unknown coordinate 'z'"),
        (("cart_pole", "--solve", "--routh"), "expected one of --routh, --in or --solve"),
        (("cart_pole", "--solve", "--units"), "expected one of --routh, --in or --solve"),
    ],
)
def test_derive_says_why_it_does_not_solve(words: tuple[str, ...], message: str) -> None:
    result = call("derive", *words)
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())


def test_a_list_says_why_it_is_none_in_closed_form_and_where_there_is_one() -> None:
    told = CliRunner().invoke(app, ["derive", "ball_in_a_bowl", "--method", "virtual_work"])
    assert "too long to be read" in told.stderr
    assert "--method lagrange has a closed form" in told.stderr
