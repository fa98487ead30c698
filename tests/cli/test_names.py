"""Every misspelt name gets the nearest valid one."""

import re
import sys
from pathlib import Path

import pytest

import prp_gym
from prp_gym.baselines import CONTROLLERS
from prp_gym.cli.main import main
from prp_gym.errors import UnknownNameError
from prp_gym.evaluation.metrics import METRICS
from prp_gym.nearest import nearest_name
from prp_gym.tasks.registration import list_envs

TASK = "PRP-Adaptive-v0"
TUNE = ("tune", "joint_pd", "-e", TASK)
TRAIN = ("train", TASK)

MISSPELT = [
    (("evaluate", "-e", "PRP-Adaptiv-v0"), "PRP-Adaptive-v0"),
    (("evaluate", "-e", "adaptive"), "PRP-Adaptive-v0"),
    (("compare", "-e", "PRP-Forces-v0"), "PRP-Force-v0"),
    (("audit", "-e", "prp-force-v0"), "PRP-Force-v0"),
    (("tune", "joint_pd", "-e", "PRP-Adptive-v0", "--budget", "1"), TASK),
    (("tune-all", "-e", "PRP-Adptive-v0"), TASK),
    (("train", "PRP-Adptive-v0"), TASK),
    (("zoo", "recipes.yml", "-e", "PRP-Adptive-v0"), TASK),
    (("export", "model.zip", "-e", "PRP-Adptive-v0", "--trust"), TASK),
    (("evaluate", "-e", TASK, "-b", "joint_dp"), "joint_pd"),
    (("compare", "-e", TASK, "-b", "admitance"), "admittance"),
    (("tune", "joint_dp", "-e", TASK, "--budget", "1"), "joint_pd"),
    (("tune-all", "-b", "joint_dp"), "joint_pd"),
    (("evaluate", "-e", TASK, "-s", "reprot"), "report"),
    (("evaluate", "-e", TASK, "-g", "tunned"), "tuned"),
    (("evaluate", "-e", TASK, "-b", "joint_pd", "-g", "reprot"), "report"),
    (("evaluate", "-e", TASK, "-b", "joint_pd", "--set", "proportional_gian=1"), "proportional_gain"),
    (("evaluate", "-e", TASK, "--backend", "rey"), "ray"),
    ((*TUNE, "--like", f"{TASK}/ppo_residual-joint_inverse_dynamic"), f"{TASK}/"),
    ((*TUNE, "--budget", "1", "-s", "randomised"), "randomized"),
    ((*TRAIN, "--algo", "td2"), "td3"),
    ((*TRAIN, "-m", "joint_positions"), "joint_position"),
    ((*TRAIN, "-m", "residual:joint_dp"), "residual:joint_pd"),
    ((*TRAIN, "--set", "gama=0.9"), "gamma"),
    ((*TRAIN, "--set", "env_kwargs.scenari=report"), "scenario"),
    ((*TRAIN, "--set", "policy_kwargs.net_archs=[8]"), "net_arch"),
    ((*TRAIN, "--set", "env_kwargs.scenario=reprot"), "report"),
    (("reproduce", "--figure", "99"), ""),
    (("evalute",), "evaluate"),
    (("tuneall",), "tune-all"),
    (("evaluate", "--episode", "3"), "--episodes"),
    (("compare", "--bseline", "joint_pd"), "--baseline"),
]


@pytest.mark.parametrize(("command", "meant"), MISSPELT, ids=lambda value: "-".join(value)[:60])
def test_misspelt_name_gets_the_nearest_one(
    command: tuple[str, ...],
    meant: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["prp-gym", *command, *(("-o", "made") if len(command) > 1 else ())])
    if command[0] == "zoo":
        monkeypatch.setattr(sys, "argv", ["prp-gym", *command])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    told = " ".join(capsys.readouterr().err.replace("│", " ").split())
    if meant:
        assert re.search(rf"(Did you mean '|Possible options: ){meant}", told)
    else:
        assert "Valid: " in told
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize(
    ("call", "meant"),
    [
        (lambda: METRICS.find("overshot"), "overshoot"),
        (lambda: CONTROLLERS.find("Impedance"), "impedance"),
        (lambda: prp_gym.load_agent(f"{TASK}/pppo_torque"), TASK),
    ],
)
def test_misspelt_name_in_python_gets_the_nearest_one(call: object, meant: str) -> None:
    with pytest.raises(UnknownNameError, match=f"Did you mean '{meant}"):
        call()  # type: ignore[operator]


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("PRP-Forc-v0", "PRP-Force-v0"),
        ("force", "PRP-Force-v0"),
        ("FORCE", "PRP-Force-v0"),
        ("zzz", ""),
        ("", ""),
        ("x" * 1000, ""),
        (3, ""),
        (None, ""),
    ],
)
def test_name_is_meant_by_a_similar_one_or_by_a_part_of_it(name: object, meant: str) -> None:
    assert nearest_name(name, list_envs()) == meant
