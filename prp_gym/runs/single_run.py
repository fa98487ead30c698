"""One episode of a controller or of an agent, by the names that a command has."""

from contextlib import closing
from dataclasses import dataclass

from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.baselines import CONTROLLERS
from prp_gym.checks import choice, random_seed
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.episode import record_episode
from prp_gym.evaluation.rollout import Rollout
from prp_gym.runs.choice import GainsChoice
from prp_gym.runs.evaluation_job import make_environment
from prp_gym.runs.selection import Selection
from prp_gym.tasks.scenario import SCENARIOS


@dataclass(frozen=True)
class SingleRun:
    """A condition in which one episode is run.

    Attributes:
        environment_id: id of the environment.
        scenario: scenario of the environment.
        seed: random seed of the episode.

    Raises:
        UnknownNameError: a scenario that does not exist.
        InvalidValueError: a seed that is not allowed.
    """

    environment_id: str
    scenario: str
    seed: int

    def __post_init__(self) -> None:
        choice("scenario", self.scenario, list(SCENARIOS))
        random_seed("seed", self.seed)

    def of_controller(self, name: str, gains: GainsChoice, control_frequency: float) -> tuple[Rollout, str]:
        """The episode of a controller.

        Args:
            name: name of the controller, or a user's code; empty for the first that is meant for the task.
            gains: gains of the controller.
            control_frequency: control frequency of the environment [Hz].

        Returns:
            the episode, and the controller with its gains in words.

        Raises:
            PRPError: a name or setting that does not exist, or a controller that cannot run there.
        """
        chosen = name or self._intended()
        selected = Selection.of([self.environment_id], [self.scenario], [chosen], gains)
        (controller,) = selected.choices
        environment = make_environment(self.environment_id, self.scenario, control_frequency)
        with closing(environment) as env:
            policy = selected.controllers.make(controller, env)
            with selected.controllers.reported(controller, env):
                rollout = record_episode(policy, env, self.seed)
        return rollout, f"{controller.name}, {_in_words(gains)}"

    def of_agent(self, name: str) -> tuple[Rollout, str]:
        """The episode of an agent, at the control frequency and in the action mode of its training.

        Args:
            name: name of an agent of the package, or path of an agent's files.

        Returns:
            the episode, and the agent in words.

        Raises:
            PRPError: an agent that does not exist, is damaged, or was trained on another task.
        """
        agent = load_agent(name)
        if agent.card.task_id != self.environment_id:
            raise InvalidValueError(
                "task of the agent", agent.card.task_id, f"{self.environment_id!r}, that of the command"
            )
        with closing(agent.make_env(scenario=self.scenario)) as env:
            return record_episode(agent, env, self.seed), f"agent {name}"

    def _intended(self) -> str:
        """The first controller that is meant for the environment."""
        for name, spec in CONTROLLERS.items():
            if self.environment_id in spec.data.intended:
                return name
        raise InvalidValueError("--baseline", None, f"a controller that runs on {self.environment_id}")


def _in_words(gains: GainsChoice) -> str:
    changed = "".join(f", {name}={value}" for name, value in gains.settings)
    return f"gains {gains.name}{changed}"
