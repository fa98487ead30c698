"""The table for the terminal: what a cell says, and that 120 columns hold all of it."""

from io import StringIO
from typing import Any

import gymnasium
import numpy as np
import pytest
from rich.console import Console

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, list_baselines, make_baseline
from prp_gym.evaluation import Evaluation, Rollout, evaluate
from prp_gym.evaluation.table import Row, evaluation_table

WIDTH = 120
LONGEST_LAW = max(BASELINES, key=len)


def render(title: str, *rows: Row) -> list[str]:
    console = Console(file=StringIO(), width=WIDTH, force_terminal=False, color_system=None)
    console.print(evaluation_table(title, rows))
    assert isinstance(console.file, StringIO)
    return console.file.getvalue().splitlines()


def episode(seed: int = 0, **changes: Any) -> Rollout:
    """Two steps to a goal of (1 rad, -0.1 m, 1 rad), arrived at once but for given errors."""
    error = np.asarray(changes.pop("error", np.zeros(3)))
    actual = np.zeros((3, 3))
    actual[1:] = np.array([1.0, -0.1, 1.0]) - error
    content: dict[str, Any] = {
        "environment_id": list_envs()[0],
        "scenario": "randomized",
        "seed": seed,
        "period": 0.01,
        "duration": 0.02,
        "fields": {
            "joint_position": actual,
            "joint_velocity": np.ones((3, 3)),
            "desired_joint_position": np.tile([1.0, -0.1, 1.0], (3, 1)),
        },
        "torque": np.zeros((2, 3)),
        "applied_torque": np.zeros((2, 3)),
        "reward": np.full(2, 0.005),
        "info": {"cost_saturation": np.zeros(2), "cost_joint_stop": np.zeros(2)},
        "diverged": False,
        "compute_time": np.full(2, 42e-6),
    }
    return Rollout(**{**content, **changes})


def row(law: str = LONGEST_LAW, **changes: Any) -> Row:
    return Row(law, Evaluation([episode(seed, **changes) for seed in range(3)], 0))


def body(*rows: Row) -> list[str]:
    """The lines below the rule."""
    lines = render("title", *rows)
    rule = next(index for index, line in enumerate(lines) if "───" in line)
    return [line for line in lines[rule + 1 :] if line.strip()]


def test_cells_show_the_known_values() -> None:
    (line,) = body(row(error=[-0.012, 0.0034, 0.5], applied_torque=np.full((2, 3), 50.0)))
    # scores ½ in every episode; RMSE over three samples, the first with the whole step; the steady error
    # is that of the last sample; the largest overshoot is joint 2's 3.4 of 100 mm; 3·50 W for 0.02 s
    assert line.split() == [
        LONGEST_LAW,
        *("0.500", "0.500-0.500"),
        *("577", "58", "707"),
        *("-12", "3.4", "500"),
        *("never", "3.4", "3", "0", "42"),
    ]


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (4e-6, "0"), (5.7e-5, "0.06"), (3.21e-3, "3.2"), (-0.0123, "-12"), (12.3, "12300")],
)
def test_errors_are_shown_in_thousandths_as_far_as_they_matter(value: float, shown: str) -> None:
    (line,) = body(row(error=[value, 0.0, 0.0]))
    assert line.split()[6] == shown


def test_what_does_not_exist_is_a_dash() -> None:
    (line,) = body(row(fields={"joint_velocity": np.zeros((3, 3))}))
    assert line.split()[3:7] == ["-"] * 4


def test_single_episode_has_no_interval() -> None:
    (line,) = body(Row("law", Evaluation([episode()], 0)))
    assert "1 episode" in line


def test_best_score_comes_first() -> None:
    rows = [row(name, reward=np.full(2, worth)) for name, worth in (("b", 0.002), ("a", 0.009), ("c", 0.005))]
    assert [line.split()[0] for line in body(*rows)] == ["a", "c", "b"]


def test_title_and_every_unit_stand_above_the_numbers() -> None:
    text = "\n".join(render("PRP-JointTracking-v0, scenario realistic", row()))
    for expected in ("PRP-JointTracking-v0, scenario realistic", "mrad mm mrad", "95 % interval"):
        assert expected in text
    assert [unit for unit in ("s", "%", "J", "µs") if unit not in text.split()] == []


WIDEST: dict[str, dict[str, Any]] = {
    "nothing": {},
    "tiny": {"error": [-5.2e-6, -1.3e-5, -1.4e-4], "applied_torque": np.full((2, 3), 0.02)},
    "small": {"error": [-0.0012, -0.0013, -0.0014], "applied_torque": np.full((2, 3), 1e3)},
    "far": {"error": [-3.1415, -0.31415, -3.1415], "applied_torque": np.full((2, 3), 9e4)},
    "saturated": {"info": {"cost_saturation": np.full(2, 3.0), "cost_joint_stop": np.full(2, 3.0)}},
    "slow": {"compute_time": np.full(2, 1.2e-3)},
    "all": {
        "error": [-3.1415, -0.31415, -3.1415],
        "applied_torque": np.full((2, 3), 6e6),
        "info": {"cost_saturation": np.full(2, 3.0), "cost_joint_stop": np.full(2, 3.0)},
        "compute_time": np.full(2, 1.2e-3),
    },
}


@pytest.mark.parametrize("law", BASELINES)
@pytest.mark.parametrize("case", WIDEST)
def test_nothing_is_cut_off_at_120_columns(law: str, case: str) -> None:
    lines = render("title", row(law, **WIDEST[case]), row(law))
    assert max(len(line.rstrip()) for line in lines) <= WIDTH
    assert not any("…" in line for line in lines)
    assert sum(law in line for line in lines) == 2


@pytest.mark.parametrize("scenario", ["report", "randomized"])
@pytest.mark.parametrize("environment_id", list_envs())
def test_table_of_real_evaluations_is_whole(environment_id: str, scenario: str) -> None:
    env = gymnasium.make(environment_id, scenario=scenario, duration=0.4)
    laws = list_baselines(env.get_wrapper_attr("observation_layout"))
    rows = [Row(law, evaluate(make_baseline(law, env), env, episodes=2)) for law in laws]
    env.close()
    lines = render(f"{environment_id}, scenario {scenario}", *rows)
    assert not any("…" in line for line in lines)
    for law in laws:
        assert sum(law in line for line in lines) == 1
