"""`ActingPolicy`: a controller or an agent in an environment that is made for it, by its name."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Self

import gymnasium

from prp_gym.agents.policy.agent_file import list_agents, load_agent
from prp_gym.baselines import CONTROLLERS
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.selection import Selection
from prp_gym.tasks.presets import find_preset

_OWN_FREQUENCY = "control_frequency"


@dataclass(frozen=True)
class ActingPolicy:
    """A policy and the environment in which it acts.

    Attributes:
        name: Name of the policy.
        env: Environment of the policy, to be closed by the caller.
        policy: Policy for that environment.
        reported: Makes a context in which an error of a user's own code is reported with its line.
    """

    name: str
    env: gymnasium.Env[Any, Any]
    policy: Policy
    reported: Callable[[], AbstractContextManager[None]] = nullcontext

    @classmethod
    def of_controller(
        cls, name: str, gains: GainsChoice, environment_id: str, keywords: dict[str, Any]
    ) -> Self:
        """A controller, or a user's own as `path/to/file.py:Name` or `package.module:Name`.

        Args:
            name: Name of the controller.
            gains: Gains of the controller.
            environment_id: Id of the environment.
            keywords: Keywords of the environment, among them its scenario.

        Raises:
            PRPError: a name, gains or keywords that are refused.
        """
        selected = Selection.of([environment_id], [keywords["scenario"]], [name], gains)
        env = gymnasium.make(environment_id, **keywords)
        try:
            policy = selected.controllers.try_out(selected.choices[0], env)
        except BaseException:
            env.close()
            raise
        label = name if gains.name == TUNED and not gains.settings else f"{name} ({_described(gains)})"
        return cls(label, env, policy, partial(selected.controllers.reported, selected.choices[0], env))

    @classmethod
    def of_agent(cls, name: str, environment_id: str, keywords: dict[str, Any]) -> Self:
        """A trained agent, in the action mode and at the control frequency of its training.

        Args:
            name: Name of a shipped agent, or path of an agent's files.
            environment_id: Id of the environment; the agent's must be of the same task.
            keywords: Keywords of the environment, among them its scenario.

        Raises:
            PRPError: a name or keywords that are refused, or an agent of another task.
        """
        agent = load_agent(name)
        task, wanted = find_preset(agent.card.environment_id).task.id, find_preset(environment_id).task.id
        if task != wanted:
            raise InvalidValueError("agent", name, f"one that was trained on {wanted}, and not on {task}")
        own = {key: value for key, value in keywords.items() if key != _OWN_FREQUENCY}
        return cls(str(name), agent.make_env(**own), agent)

    @classmethod
    def of_name(cls, name: str, environment_id: str, keywords: dict[str, Any]) -> Self:
        """A controller with its tuned gains, or an agent, whichever has the name.

        Raises:
            UnknownNameError: neither a controller nor an agent.
            PRPError: see `of_controller` and `of_agent`.
        """
        if name in CONTROLLERS or ":" in name:
            return cls.of_controller(name, GainsChoice(), environment_id, keywords)
        if name in list_agents() or Path(name).parent != Path():
            return cls.of_agent(name, environment_id, keywords)
        raise UnknownNameError("controller or agent", name, [*CONTROLLERS, *list_agents()])


def _described(gains: GainsChoice) -> str:
    """The gains in a few words."""
    return ", ".join([gains.name, *(f"{name}={value}" for name, value in gains.settings)])
