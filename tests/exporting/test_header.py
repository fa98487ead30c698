"""The text of exported headers: what it says, what it lacks, and what compilers take."""

import re
import shutil
import subprocess
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import Baseline, make_baseline
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.errors import DataDependentBranchError, InvalidValueError, UntraceableError
from prp_gym.exporting import c_header, default_prefix
from prp_gym.exporting.c_header import LONGEST_PREFIX
from prp_gym.exporting.comment_text import comment_text
from prp_gym.exporting.header_comment import settings_digest
from prp_gym.exporting.operation_counts import KINDS, count_operations
from prp_gym.symbolic.function import trace
from prp_gym.symbolic.operations import OPERATIONS
from prp_gym.tasks.registration import list_envs
from tests.exporting.compiled_header import STRICT, compile_headers, compile_strictly, controllers
from tests.support.compiler import needs_compiler

FORCE = "PRP-ForcePosition-v0"
OF_THE_LIBRARY = {"sin", "cos", "sqrt", "atan2", "exp", "log", "fmod", "floor", "rint", "sincos"}
"""Functions of <math.h> that a header may call; a compiler may join the first two."""


def force_controller() -> Baseline[Any]:
    return controllers(FORCE)["force_inner_position"]


def joint_controller() -> Baseline[Any]:
    return controllers("PRP-JointTracking-v0")["joint_pd"]


@pytest.mark.parametrize("environment_id", list_envs())
def test_every_number_of_the_observation_is_explained_in_ascii(environment_id: str) -> None:
    policy = controllers(environment_id)["joint_pd"]
    header, layout = c_header(policy), policy.interface.layout
    assert header.text.isascii()
    assert header.observation_size == layout.size
    rows = re.findall(r"^ \* +(\d+)  (\w+)\[(\d+)\] +(\S.*?)  +(\S+) +(\S+)$", header.text, re.MULTILINE)
    assert [int(row[0]) for row in rows] == list(range(layout.size))
    expected = [
        (field.name, str(index), comment_text(unit), f"{low:g}", f"{high:g}")
        for field in layout.fields
        for index, (unit, low, high) in enumerate(zip(field.units, field.low, field.high, strict=True))
    ]
    assert [row[1:] for row in rows] == expected
    for field in layout.fields:
        assert comment_text(field.description) in header.text


def test_comment_names_controller_gains_environment_period_and_limits() -> None:
    policy = force_controller()
    text = c_header(policy, facts={"code": "of a user"}).text
    comment = text[: text.index("*/")]
    assert "force_inner_position with gains 'tuned'" in comment
    assert FORCE in comment
    assert "0.002 s (500 Hz)" in comment
    assert settings_digest(policy) in comment
    assert "code            of a user" in comment
    assert "bandwidth [rad/s]: 20.0" in comment
    for limit in policy.interface.torque_limit.tolist():
        assert f"at most {limit!r} in magnitude" in comment


def test_same_controller_gives_the_same_text_and_other_gains_another() -> None:
    policy = joint_controller()
    assert c_header(policy).text == c_header(policy).text
    settings = replace(policy.settings, derivative_gain=np.array([1.0, 2.0, 3.0]))
    other = type(policy)(policy.interface, settings)
    other.origin = policy.origin
    assert settings_digest(other) != settings_digest(policy)
    assert c_header(other).text != c_header(policy).text


def test_header_has_no_allocation_and_no_variables() -> None:
    text = c_header(force_controller()).text
    assert not re.search(r"alloc|free\s*\(|extern|goto|while|longjmp", text[text.index("*/") :])
    assert re.findall(r"^#include.*$", text, re.MULTILINE) == ["#include <math.h>"]
    assert set(re.findall(r"^\w+ \w+", text, re.MULTILINE)) <= {"static inline", "typedef char"}


def test_counted_operations_are_those_of_the_text() -> None:
    header = c_header(force_controller())
    body = header.text[header.text.index("_step(const") :]
    assert header.operations["sqrt"] == body.count(" sqrt(")
    assert header.operations["divisions"] == body.count("(double)")
    assert header.operations["sin and cos"] == len(re.findall(r" (?:sin|cos)\(", body))
    assert sum(header.operations.values()) == body.count("    const ")
    rows = re.findall(r"^ \* +(\S.*?)  +(\d+) +\d+$", header.text, re.MULTILINE)
    assert {name: int(count) for name, count in rows} == {k: v for k, v in header.operations.items() if v}


def test_every_operation_has_a_kind() -> None:
    assert {operation for group in KINDS.values() for operation in group} == set(OPERATIONS)
    function = trace("f", lambda x: {"y": np.sqrt(x * x) / (x + 1.0)}, {"x": (2,)})
    counted = {kind: count for kind, count in count_operations(function).items() if count}
    assert counted == {"additions and subtractions": 2, "multiplications": 2, "divisions": 2, "sqrt": 2}


@needs_compiler
def test_machine_code_needs_the_mathematical_library_alone(tmp_path: Path) -> None:
    if shutil.which("nm") is None:
        pytest.skip("no program nm on this machine")
    header = c_header(force_controller())
    (tmp_path / "own.h").write_text(header.text, encoding="ascii")
    name = header.prefix
    source = '#include "own.h"\nint use(const double *, double *, double *);\nint use(const double *o, '
    source += f"double *s, double *t) {{ return {name}_begin(o, s) + {name}_step(o, s, t); }}\n"
    made = compile_strictly(source, tmp_path, "-c", "-O2")
    listed = subprocess.run(["nm", str(made)], capture_output=True, text=True, check=True).stdout
    symbols = [line.split()[-2:] for line in listed.splitlines()]
    assert {symbol for kind, symbol in symbols if kind == "U"} <= OF_THE_LIBRARY
    assert not {kind for kind, _ in symbols} & set("bBdDcC")  # variables
    assert ["T", "use"] in symbols


@needs_compiler
def test_headers_of_several_controllers_stand_in_one_program_in_c_plus_plus(tmp_path: Path) -> None:
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("no compiler g++ on this machine")
    headers = [c_header(force_controller()), c_header(joint_controller()), c_header(joint_controller(), "b")]
    includes = []
    for header in headers:
        (tmp_path / f"{header.prefix}.h").write_text(header.text, encoding="ascii")
        includes += [f'#include "{header.prefix}.h"'] * 2
    path = tmp_path / "program.cpp"
    path.write_text("\n".join([*includes, "int main() { return 0; }\n"]), encoding="ascii")
    options = ["-std=c++17", *STRICT[1:], "-fsyntax-only"]
    done = subprocess.run([compiler, *options, str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@needs_compiler
def test_main_loop_of_the_documentation_compiles(tmp_path: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "export.md").read_text(encoding="utf-8")
    (loop,) = re.findall(r"^```c\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert (
        "prp-gym export-c force_inner_position --env PRP-ForcePosition-v0 --prefix arm --output arm.h" in page
    )
    (tmp_path / "arm.h").write_text(c_header(force_controller(), "arm").text, encoding="ascii")
    compile_strictly(loop, tmp_path, "-c")


@needs_compiler
def test_fast_mathematics_is_refused_by_the_header(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="must be compiled without -ffast-math"):
        compile_headers([c_header(joint_controller())], tmp_path, "-ffast-math")


@needs_compiler
@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1.001e12])
def test_observation_that_python_refuses_gives_zero_torques_and_leaves_the_state(
    number: float, tmp_path: Path
) -> None:
    policy = force_controller()
    header = c_header(policy)
    (compiled,) = compile_headers([header], tmp_path)
    good = np.full(header.observation_size, 0.1)
    state, torque = np.full(header.state_size, 0.5), np.full(3, 7.0)
    for index in (0, header.observation_size - 1):
        bad = good.copy()
        bad[index] = number
        assert compiled.begin(bad, state) == 1
        assert compiled.step(bad, state, torque) == 1
        assert (state == 0.5).all()
        assert (torque == 0.0).all()
        torque.fill(7.0)
    assert compiled.begin(good, state) == 0
    assert compiled.step(good, state, torque) == 0
    assert (torque != 7.0).all()


@needs_compiler
@pytest.mark.parametrize("number", [np.nan, np.inf, 1e19])
def test_state_that_python_refuses_gives_zero_torques_and_is_left(number: float, tmp_path: Path) -> None:
    header = c_header(controllers("PRP-JointTracking-v0")["joint_inverse_dynamics"])
    (compiled,) = compile_headers([header], tmp_path)
    state, torque = np.array([0.0, number, 0.0]), np.full(3, 7.0)
    assert compiled.step(np.full(header.observation_size, 0.1), state, torque) == 1
    np.testing.assert_array_equal(state, [0.0, number, 0.0])
    assert (torque == 0.0).all()


def test_names_begin_with_the_prefix() -> None:
    policy = joint_controller()
    assert default_prefix(policy) == c_header(policy).prefix == "prp_joint_pd_joint_tracking"
    text = c_header(policy, "arm7").text
    assert "arm7_step(" in text
    assert "#define ARM7_PERIOD 0.002" in text
    assert "joint_tracking" not in text[text.index("*/") :]
    for environment_id in list_envs():
        for other in controllers(environment_id).values():
            assert len(default_prefix(other)) <= LONGEST_PREFIX


@pytest.mark.parametrize(
    "prefix", ["", "1a", "a-b", "a b", "_a", "ä", "a;", "a" * (LONGEST_PREFIX + 1), "a\n"]
)
def test_prefix_that_cannot_begin_a_name_of_c_is_refused(prefix: str) -> None:
    with pytest.raises(InvalidValueError, match="prefix is"):
        c_header(joint_controller(), prefix)


class Branching(JointPDController):
    def torque(self, observed: Any) -> Any:
        torque = super().torque(observed)
        return torque if (torque > 0.0).any() else 2.0 * torque


class Predicting(JointPDController):
    def predict(self, *arguments: Any, **options: Any) -> Any:
        return super().predict(*arguments, **options)


@pytest.mark.parametrize(
    ("kind", "error", "reason"),
    [
        (Branching, DataDependentBranchError, "a branch on .* cannot be traced"),
        (Predicting, UntraceableError, "Predicting replaces `Baseline.predict`"),
    ],
)
def test_what_cannot_be_traced_is_refused(
    kind: type[JointPDController], error: type[UntraceableError], reason: str
) -> None:
    policy = joint_controller()
    with pytest.raises(error, match=reason):
        c_header(kind(policy.interface, policy.settings))


def test_what_is_no_baseline_is_refused() -> None:
    with pytest.raises(UntraceableError, match="object has a method `predict` of its own"):
        c_header(object())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("q̇_d and ẍ [N·m/rad²]", "q_dot_d and x_ddot [N m/rad^2]"),
        ("é 漢\n*/ /*/ ??/\0", "e ? * / / * / ? ?/?"),
    ],
)
def test_comments_are_ascii_and_cannot_end_early(text: str, plain: str) -> None:
    assert comment_text(text) == plain


def test_controller_that_optimises_a_plan_is_refused() -> None:
    with closing(gymnasium.make("PRP-JointTracking-v0")) as env:
        controller = make_baseline("model_predictive", env)
    with pytest.raises(UntraceableError):
        c_header(controller)
