"""Training on the compiled engine, which a recipe names."""

from typing import Any

import pytest

from prp_gym.agents.training.model import Learner, make_learner
from prp_gym.agents.training.recipes import load_recipe
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

SMALL = ("n_envs=4", "n_steps=8", "batch_size=16", "learning_rate=5.0e-4")


def trained(environment_id: str, mode: str, engine: str) -> Learner:
    """A learner after one rollout and its updates."""
    recipe = load_recipe("ppo", environment_id, mode, overrides=[*SMALL, f"env_kwargs.engine={engine}"])
    learner = make_learner(recipe, 0)
    learner.model.learn(32)
    return learner


@pytest.mark.parametrize(
    ("environment_id", "mode"),
    [("PRP-Force-v0", "variable_force_position"), ("PRP-Impedance-v0", "admittance")],
)
def test_one_update_is_that_on_mujoco(environment_id: str, mode: str) -> None:
    learners = [trained(environment_id, mode, engine) for engine in ("mujoco", "compiled")]
    one, other = (learner.model.policy.state_dict() for learner in learners)
    for name, values in one.items():
        # the engines differ below 1e-5 in a period; an update of Adam divides gradients by their size
        assert other[name].numpy() == pytest.approx(values.numpy(), abs=1e-3), name
    made: Any = learners[1].env.unwrapped
    assert made.get_attr("config", 0)[0].engine == "compiled"
    for learner in learners:
        learner.close()
