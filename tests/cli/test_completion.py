"""The shell completes commands, options and names, without packages that it does not need."""

from collections.abc import Callable
from typing import Any

import pytest
from typer.testing import CliRunner

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.baselines import CONTROLLERS
from prp_gym.cli import completion
from prp_gym.cli.main import app
from prp_gym.envs.action_mode import ACTION_MODES
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.scenario import SCENARIOS
from tests.conformance.test_public_api import in_fresh_python


def completed(line: str) -> list[str]:
    """What bash offers after a line."""
    words = line.split(" ")
    result = CliRunner().invoke(
        app,
        [],
        prog_name="prp-gym",
        env={
            "_PRP_GYM_COMPLETE": "complete_bash",
            "COMP_WORDS": line,
            "COMP_CWORD": str(len(words) - 1),
        },
    )
    return result.output.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("prp-gym eval", ["evaluate"]),
        ("prp-gym evaluate --epi", ["--episodes"]),
        ("prp-gym evaluate --env PRP-Force", [name for name in list_envs() if name.startswith("PRP-Force")]),
        ("prp-gym evaluate -b joint_", [name for name in CONTROLLERS if name.startswith("joint_")]),
        ("prp-gym compare -s ", list(SCENARIOS)),
        ("prp-gym tune joint_p", ["joint_pd"]),
        ("prp-gym train --algo ", list(ALGORITHMS)),
        ("prp-gym evaluate -g rep", ["report"]),
        ("prp-gym evaluate --backend l", ["loky"]),
        ("prp-gym tune --engine c", ["compiled"]),
        ("prp-gym train PRP-Adaptive", ["PRP-Adaptive-v0", "PRP-Adaptive-RL-v0"]),
    ],
)
def test_shell_offers_the_names_that_start_with_what_was_typed(line: str, offered: list[str]) -> None:
    assert sorted(completed(line)) == sorted(offered)


FUNCTIONS = [
    *(completion.environments, completion.learning_ids, completion.controllers, completion.scenarios),
    *(completion.gain_sets, completion.agents, completion.action_modes, completion.algorithms),
    *(completion.backends, completion.engines),
]


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_names_are_completed_whatever_their_capitals(function: Callable[[str], list[str]]) -> None:
    every = function("")
    assert len(every) == len(set(every)) > 0
    first = every[0]
    assert first in function(first[:3].upper())
    assert function("no such name") == []


def test_action_modes_of_a_family_are_completed_with_their_controllers() -> None:
    offered = completion.action_modes("")
    assert {"torque", "residual:joint_pd"} <= set(offered)
    assert {name for name, spec in ACTION_MODES.items() if not spec.is_family} <= set(offered)


def test_completion_imports_no_packages_that_it_does_not_need() -> None:
    code = """
import json, sys
from prp_gym.cli import completion
names = [name for name in vars(completion) if name.islower() and not name.startswith("_")]
for name in names:
    getattr(completion, name)("")
heavy = ("torch", "stable_baselines3", "sb3_contrib", "tensorboard", "matplotlib", "optuna", "ray", "yaml")
print(json.dumps([name for name in heavy if name in sys.modules]))
"""
    found: Any = in_fresh_python(code)
    assert found == []
