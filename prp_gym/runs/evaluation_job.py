"""Jobs whose policy is a controller with its gains."""

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import gymnasium

from prp_gym.errors import MissingFieldError
from prp_gym.evaluation.evaluate import episodes_to_run, evaluate
from prp_gym.runs.choice import ControllerChoice
from prp_gym.runs.controllers import Controllers, settings_of
from prp_gym.runs.job import Record, make_record
from prp_gym.tasks.setup import MUJOCO


@dataclass(frozen=True)
class EvaluationJob:
    """A controller on an environment, and all that its evaluation depends on.

    Attributes:
        environment_id: id of the environment, as `gymnasium.make` takes it.
        scenario: scenario of the environment.
        controller: controller that is evaluated, with its gains.
        control_frequency: control frequency of the environment [Hz].
        episodes: number of episodes, 1 in a deterministic scenario.
        seed: seed of the first episode.
        engine: engine of the environment.
    """

    environment_id: str
    scenario: str
    controller: ControllerChoice
    control_frequency: float
    episodes: int
    seed: int
    engine: str = MUJOCO

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{self.environment_id}_{self.scenario}_{self.controller.file_name}"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        choice = self.controller
        declared = controllers.find(choice)
        with closing(
            make_environment(self.environment_id, self.scenario, self.control_frequency, self.engine)
        ) as env:
            policy = controllers.make(choice, env)
            with controllers.reported(choice, env):
                evaluation = evaluate(policy, env, self.episodes, self.seed)
            settings = settings_of(declared, choice, policy)
            record = make_record(evaluation, choice.name, settings, {"controller": declared.revision})
        return {**record, **choice.facts}


def list_jobs(
    conditions: Iterable[tuple[str, str]],
    choices: Sequence[ControllerChoice],
    controllers: Controllers,
    control_frequency: float,
    episodes: int,
    seed: int,
    engine: str = MUJOCO,
) -> list[EvaluationJob]:
    """The controllers that can run on each environment, all made once before anything is run.

    Args:
        conditions: environment ids and scenarios.
        choices: controllers with their gains.
        controllers: source of the controllers.
        control_frequency: control frequency of the environments [Hz].
        episodes: number of episodes of each job; a deterministic scenario has one.
        seed: seed of the first episode.
        engine: engine of the environments.

    Raises:
        UnknownNameError: a gain set or setting that one of the controllers lacks.
        InvalidValueError: a control frequency at which the gains of one of the controllers are unstable.
        UserCodeError: a user's controller that fails.
    """
    jobs = []
    for environment_id, scenario in conditions:
        with closing(make_environment(environment_id, scenario, control_frequency, engine)) as env:
            count = episodes_to_run(env, episodes)
            found = [choice for choice in choices if _can_run(controllers, choice, env)]
        jobs += [
            EvaluationJob(environment_id, scenario, choice, control_frequency, count, seed, engine)
            for choice in found
        ]
    return jobs


def make_environment(
    environment_id: str, scenario: str, control_frequency: float, engine: str = MUJOCO
) -> gymnasium.Env[Any, Any]:
    """An environment whose actions are torques."""
    keywords: dict[str, Any] = {"control_frequency": control_frequency, "engine": engine}
    return gymnasium.make(environment_id, scenario=scenario, **keywords)


def _can_run(controllers: Controllers, choice: ControllerChoice, env: gymnasium.Env[Any, Any]) -> bool:
    """Whether an environment observes what a controller reads; anything else that is wrong is raised."""
    if not controllers.runs_on(choice, env):
        return False
    try:
        controllers.try_out(choice, env)
    except MissingFieldError:
        return False
    return True
