"""`Candidates`: the policies that a search tries."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from prp_gym.evaluation.rollout import Policy
from prp_gym.tuning.search_space import Parameter


class Space(Protocol):
    """The settings over which a search runs, around those of a controller; see `SearchSpace`."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The factors."""

    @property
    def start(self) -> dict[str, float]:
        """The factors that give the settings at the centre of the space."""

    def settings(self, factors: Mapping[str, float]) -> dict[str, Any]:
        """The settings that factors give, by name."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """The policies that a search tries: one for each choice of the factors of a space.

    Attributes:
        space: search space of the settings.
        make_policy: function that makes a policy from settings; it may refuse them with a `PRPError`.
    """

    space: Space
    make_policy: Callable[[Mapping[str, Any]], Policy]

    def make(self, factors: Mapping[str, float]) -> Policy:
        """The policy with the settings that factors give.

        Raises:
            PRPError: settings that the controller refuses.
        """
        return self.make_policy(self.space.settings(factors))
