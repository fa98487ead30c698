"""`PolicySource`: where the environment and the policy of a session come from."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import gymnasium

from prp_gym.evaluation.rollout import Policy
from prp_gym.tuning.search_space import Parameter


class PolicySource(ABC):
    """Makes the environment and the policy of a session.

    Attributes:
        name: name of the controller or agent, as the page shows it.
        gains: name of the gain set; empty where there is none.
    """

    name: str
    gains: str = ""

    @abstractmethod
    def make_env(self, scenario: str) -> gymnasium.Env[Any, Any]:
        """Make the environment in which the policy acts.

        Raises:
            PRPError: a scenario or keyword that the environment refuses.
        """

    @abstractmethod
    def make_policy(self, env: gymnasium.Env[Any, Any], factors: Mapping[str, float]) -> Policy:
        """Make the policy.

        Args:
            env: environment of `make_env`.
            factors: factors by the names of `parameters`; a missing one is 1.

        Raises:
            PRPError: a policy that does not fit the environment, or settings that it refuses.
        """

    def parameters(self, env: gymnasium.Env[Any, Any]) -> tuple[Parameter, ...]:
        """Factors on the settings of the policy; none for a policy without settings."""
        return ()

    def settings(self, policy: Policy) -> dict[str, tuple[Any, str]]:
        """Values of the settings and their units, by name; none for a policy without settings."""
        return {}

    def reported(self, env: gymnasium.Env[Any, Any]) -> AbstractContextManager[None]:
        """A context in which an error of the policy's own code is reported with its line."""
        return nullcontext()
