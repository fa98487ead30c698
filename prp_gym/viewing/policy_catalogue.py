"""`PolicyCatalogue`: the controllers and agents that a session of an environment may use."""

import gymnasium

from prp_gym.agents.policy.agent_file import list_agents
from prp_gym.baselines import CONTROLLERS, list_baselines
from prp_gym.checks import choice
from prp_gym.runs.choice import TUNED, ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.viewing.agent_source import AgentSource
from prp_gym.viewing.controller_source import ControllerSource
from prp_gym.viewing.policy_source import PolicySource


class PolicyCatalogue:
    """The policies of an environment by name: its controllers, then its agents.

    Args:
        environment_id: id of the environment.
        control_frequency: control frequency of the controllers [Hz].
        first: source with which the session starts.
    """

    def __init__(self, environment_id: str, control_frequency: float, first: PolicySource) -> None:
        self._environment_id, self._frequency, self._first = environment_id, control_frequency, first
        env = gymnasium.make(environment_id)
        self._controllers = list_baselines(env.get_wrapper_attr("observation_layout"))
        env.close()
        self._agents = list_agents(environment_id)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the controllers and agents."""
        return tuple(dict.fromkeys((self._first.name, *self._controllers, *self._agents)))

    def gain_sets(self, name: str) -> tuple[str, ...]:
        """Names of the gain sets of a controller; none of an agent."""
        if name == self._first.name:
            return self._first.gain_sets if isinstance(self._first, ControllerSource) else ()
        return CONTROLLERS.find(name).gain_sets if name in self._controllers else ()

    def make(self, name: str, gains: str = TUNED) -> PolicySource:
        """The source of a policy.

        Args:
            name: one of `names`.
            gains: one of its gain sets; ignored by a policy without any.

        Raises:
            UnknownNameError: another name, or a gain set that the controller does not have.
        """
        choice("controller or agent", name, self.names)
        if name == self._first.name and gains in ("", self._first.gains):
            return self._first
        if name in self._agents:
            return AgentSource(name, self._environment_id)
        if isinstance(self._first, ControllerSource) and name == self._first.name:
            return self._first.with_gains(choice("gain set", gains, self._first.gain_sets))
        choice("gain set", gains, self.gain_sets(name))
        chosen = ControllerChoice(name, gains=GainsChoice(gains))
        return ControllerSource(Controllers(), chosen, self._environment_id, self._frequency)
