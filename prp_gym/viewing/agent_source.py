"""`AgentSource`: a trained agent in the environment of its training."""

from collections.abc import Mapping
from typing import Any

import gymnasium

from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.rollout import Policy
from prp_gym.viewing.policy_source import PolicySource


class AgentSource(PolicySource):
    """A trained agent, in the action mode and at the control frequency of its training.

    Args:
        name_or_path: name of an agent that comes with the package, or path of its files.
        environment_id: id of the environment, that of the agent's task or of its learning preset.

    Attributes:
        action_mode: action mode of the training.
        control_frequency: control frequency of the training [Hz].

    Raises:
        PRPError: see `load_agent`.
        InvalidValueError: an agent of another environment.
    """

    def __init__(self, name_or_path: str, environment_id: str) -> None:
        self._agent = load_agent(name_or_path)
        card = self._agent.card
        if environment_id not in (card.task_id, card.environment_id):
            raise InvalidValueError(f"environment of agent {name_or_path!r}", card.task_id, environment_id)
        self.name = name_or_path
        self.action_mode, self.control_frequency = card.action_mode, card.control_frequency

    def make_env(self, scenario: str) -> gymnasium.Env[Any, Any]:
        """See `PolicySource.make_env`."""
        return self._agent.make_env(scenario=scenario)

    def make_policy(self, env: gymnasium.Env[Any, Any], factors: Mapping[str, float]) -> Policy:
        """See `PolicySource.make_policy`."""
        self._agent.check_env(env)
        return self._agent
