"""A user's class with `predict` as a controller that is made for an environment."""

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from prp_gym.baselines import ControlInterface
from prp_gym.errors import UnknownNameError
from prp_gym.evaluation.rollout import Policy

_POSITIONAL = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
_VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


@dataclass(frozen=True)
class Predictor:
    """A class with Stable-Baselines3's `predict`.

    Its constructor gets the `ControlInterface` if it has a parameter without a default, and no argument
    otherwise; parameters with a default are the settings.

    Attributes:
        name: listed name of the predictor.
        kind: class that is instantiated as the policy.
        revision: revision of the predictor's behaviour.
    """

    name: str
    kind: type[Any]
    revision: int = 1

    @property
    def defaults(self) -> dict[str, Any]:
        """The settings by name, with their default values."""
        return {
            entry.name: entry.default
            for entry in inspect.signature(self.kind).parameters.values()
            if entry.default is not entry.empty and entry.kind not in _VARIADIC
        }

    def make(self, env: Any, values: Mapping[str, Any]) -> Policy:
        """The policy for an environment.

        Args:
            env: an environment of this suite.
            values: settings that differ from the defaults, by name.

        Raises:
            UnknownNameError: a setting that its constructor does not have.
        """
        valid = self.defaults
        for name in values:
            if name not in valid:
                raise UnknownNameError(f"setting of controller {self.name!r}", name, valid)
        arguments = (ControlInterface.of(env),) if self._takes_interface else ()
        policy: Policy = self.kind(*arguments, **values)
        return policy

    @property
    def _takes_interface(self) -> bool:
        entries = inspect.signature(self.kind).parameters.values()
        return any(entry.kind in _POSITIONAL and entry.default is entry.empty for entry in entries)
