"""The command `prp-gym export-c`: a header that compiles, or nothing."""

import json
import os
import sys
from pathlib import Path
from typing import Any

import pytest

from prp_gym.cli.main import main
from prp_gym.exporting import c_header
from tests.cli.test_main import refusal
from tests.exporting.compiled_header import compile_strictly, controllers
from tests.support.compiler import needs_compiler

ID = "PRP-JointTracking-v0"
CODE = """
import numpy as np
import prp_gym
from prp_gym.baselines.joint_pd import JointPDController


@prp_gym.controller
def pd(joint_position, joint_velocity, desired_joint_position, *, stiffness=200.0):
    return stiffness * (desired_joint_position - joint_position) - 20.0 * joint_velocity


@prp_gym.controller
def branching(joint_position):
    return -joint_position if joint_position.max() > 0.3 else joint_position


class MyController(JointPDController):
    def torque(self, observed):
        return 0.5 * super().torque(observed)


class Free:
    def __init__(self, interface):
        self.size = len(interface.torque_limit)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((*np.shape(observation)[:-1], self.size), dtype=np.float32), None
"""


@pytest.fixture(autouse=True)
def code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's folder with a file of controllers, which is the current one."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(CODE, encoding="utf-8")


def export(monkeypatch: pytest.MonkeyPatch, *options: Any) -> None:
    monkeypatch.setattr(sys, "argv", ["prp-gym", "export-c", *map(str, options)])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 0


def test_header_is_that_of_the_controller(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    export(monkeypatch, "joint_pd", "--env", ID, "--output", "new/arm.h")
    assert "header: new/arm.h" in capsys.readouterr().out
    expected = c_header(controllers(ID)["joint_pd"], facts={"gains": "tuned"})
    assert Path("new/arm.h").read_text(encoding="ascii") == expected.text
    assert os.listdir("new") == ["arm.h"]


def test_gains_settings_frequency_and_prefix_reach_the_header(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gains = ("--gains", "tuned_50hz", "--set", "derivative_gain=3.5", "--control-frequency", 50)
    export(monkeypatch, "--baseline", "joint_pd", "-e", ID, *gains, "--prefix", "arm", "-o", "a.h", "--json")
    report = json.loads(capsys.readouterr().out)
    assert report["header"] == "a.h"
    assert (report["prefix"], report["controller"], report["environment"]) == ("arm", "joint_pd", ID)
    assert (report["observation_size"], report["state_size"], report["torque_size"]) == (27, 0, 3)
    assert report["operations"]["multiplications"] > 0
    text = Path("a.h").read_text(encoding="ascii")
    assert "derivative_gain [N m s/rad, N s/m, N m s/rad]: 3.5, 3.5, 3.5" in text
    assert "joint_pd with gains 'tuned_50hz', derivative_gain changed" in text
    assert "#define ARM_PERIOD 0.02 " in text


def test_header_without_output_has_a_folder_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    export(monkeypatch, "joint_pd", "--env", ID, "--name", "first")
    (path,) = Path("results/export-c").glob("*first/*.h")
    assert path.name == "prp_joint_pd_joint_tracking.h"


@needs_compiler
@pytest.mark.parametrize("name", ["pd", "MyController"])
def test_controller_of_a_user_is_exported(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gains = ["--gains", "gains.toml"] if name == "MyController" else []
    Path("gains.toml").write_text("proportional_gain = 9.0\nderivative_gain = 2.0\n", encoding="utf-8")
    export(monkeypatch, f"mine.py:{name}", "--env", ID, *gains, "--output", "own.h")
    assert capsys.readouterr().err == ""
    text = Path("own.h").read_text(encoding="ascii")
    assert f"code            mine.py:{name}, SHA-256 " in text
    prefix = {"pd": "prp_pd_joint_tracking", "MyController": "prp_my_controller_joint_tracking"}[name]
    assert f"static inline int {prefix}_step(" in text
    compile_strictly('#include "own.h"\nint main(void) { return 0; }\n', tmp_path)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("mine.py:branching", "--env", ID), "mine.py, line 14: DataDependentBranchError: a branch on"),
        (("mine.py:Free", "--env", ID), "Free has a method `predict` of its own"),
        (("joint_pd", "--env", ID, "--prefix", "1a"), "prefix is '1a'; allowed: up to"),
        (("joint_pd", "--env", ID, "--set", "derivative_gain=-1"), "derivative_gain is -1"),
        (("force_feedforward", "--env", ID), "reads observation fields that this environment does not give"),
        (("no_such", "--env", ID), "unknown baseline 'no_such'"),
        (("joint_pd", "--env", "no-env"), "unknown environment 'no-env'"),
        (("joint_pd", "--baseline", "joint_pd", "--env", ID), "exactly one name by the two together"),
        (("--env", ID), "exactly one name by the two together"),
    ],
)
def test_nothing_is_written_for_what_is_refused(
    options: tuple[str, ...],
    reason: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    message = refusal(capsys, monkeypatch, "export-c", *options, "--output", "new/a.h")
    assert reason in message
    assert not Path("new").exists()


def test_header_ends_in_h(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    message = refusal(capsys, monkeypatch, "export-c", "joint_pd", "--env", ID, "--output", "a.c")
    assert "--output is 'a.c'; allowed: a file that ends in .h" in message
