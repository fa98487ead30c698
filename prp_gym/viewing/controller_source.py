"""`ControllerSource`: a controller with its gains, registered or a user's own."""

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any

import gymnasium

from prp_gym.baselines import Baseline, ControllerSpec
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers, gain_sets_of, settings_of
from prp_gym.tuning.keyword_space import KeywordSpace
from prp_gym.tuning.search_space import Parameter, SearchSpace
from prp_gym.viewing.policy_source import PolicySource

_NOT_SHOWN = ("gains", "model")


class ControllerSource(PolicySource):
    """A controller that sets joint torques.

    Args:
        controllers: source of the controllers of the command.
        choice: controller with its gains.
        environment_id: id of the environment.
        control_frequency: control frequency [Hz].
    """

    def __init__(
        self,
        controllers: Controllers,
        choice: ControllerChoice,
        environment_id: str,
        control_frequency: float,
    ) -> None:
        self._controllers, self._choice = controllers, choice
        self._environment_id, self._frequency = environment_id, control_frequency
        self._controller = controllers.find(choice)
        self.name, self.gains = choice.name, choice.gains.name

    @property
    def gain_sets(self) -> tuple[str, ...]:
        """Names of the gain sets, among them that of a user's file if it was chosen."""
        names = gain_sets_of(self._controller)
        return names if self.gains in names else (*names, self.gains)

    def with_gains(self, gains: str) -> "ControllerSource":
        """The same controller with another of its gain sets."""
        chosen = replace(self._choice, gains=GainsChoice(gains))
        return ControllerSource(self._controllers, chosen, self._environment_id, self._frequency)

    def make_env(self, scenario: str) -> gymnasium.Env[Any, Any]:
        """See `PolicySource.make_env`."""
        made: gymnasium.Env[Any, Any] = gymnasium.make(
            self._environment_id, scenario=scenario, control_frequency=self._frequency
        )
        return made

    def make_policy(self, env: gymnasium.Env[Any, Any], factors: Mapping[str, float]) -> Policy:
        """See `PolicySource.make_policy`."""
        made = self._controllers.make(self._choice, env)
        changed = {name: factor for name, factor in factors.items() if factor != 1.0}
        if not changed:
            return made
        space = self._space(made)
        return self._controllers.make_with(self._choice, env, space.settings({**space.start, **changed}))

    def parameters(self, env: gymnasium.Env[Any, Any]) -> tuple[Parameter, ...]:
        """See `PolicySource.parameters`; they are those over which `prp-gym tune` searches."""
        space = self._space(self._controllers.make(self._choice, env))
        try:
            return space.parameters
        except InvalidValueError:  # a user's class without numeric keyword arguments
            return ()

    def settings(self, policy: Policy) -> dict[str, tuple[Any, str]]:
        """See `PolicySource.settings`."""
        values = settings_of(self._controller, self._choice, policy)
        units = policy.settings_class.units() if isinstance(policy, Baseline) else {}
        return {n: (value, units.get(n, "")) for n, value in values.items() if n not in _NOT_SHOWN}

    def reported(self, env: gymnasium.Env[Any, Any]) -> AbstractContextManager[None]:
        """See `PolicySource.reported`."""
        return self._controllers.reported(self._choice, env) if self._choice.sha256 else nullcontext()

    def _space(self, policy: Any) -> SearchSpace | KeywordSpace:
        """The settings around those of a policy."""
        if isinstance(self._controller, ControllerSpec):
            return SearchSpace.of(self._controller, policy.settings)
        values = settings_of(self._controller, self._choice, policy)
        return KeywordSpace({name: value for name, value in values.items() if name != "gains"})
