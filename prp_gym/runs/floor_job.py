"""Jobs whose policy is a floor: zero torque, or holding the start pose."""

from collections.abc import Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import ClassVar

from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.floors import FLOORS
from prp_gym.evaluation.evaluate import episodes_to_run, evaluate
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import make_environment
from prp_gym.runs.job import Record, make_record
from prp_gym.tasks.setup import MUJOCO


@dataclass(frozen=True)
class FloorJob:
    """A floor on an environment.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        floor: name of the floor.
        control_frequency: control frequency of the environment [Hz].
        episodes: number of episodes.
        seed: random seed of the first episode.
        engine: engine of the environment.
        specs: declarations among which the floor is found by name.
    """

    specs: ClassVar[Mapping[str, ControllerSpec]] = FLOORS

    environment_id: str
    scenario: str
    floor: str
    control_frequency: float
    episodes: int
    seed: int
    engine: str = MUJOCO

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{self.environment_id}_{self.scenario}_{self.floor}_floor"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        with closing(
            make_environment(self.environment_id, self.scenario, self.control_frequency, self.engine)
        ) as env:
            spec = self.specs[self.floor]
            evaluation = evaluate(spec.make(env), env, self.episodes, self.seed)
            record = make_record(evaluation, spec.name, {}, {"controller": spec.revision})
        return {**record, "floor": self.floor in FLOORS}


def list_floors(
    conditions: Iterable[tuple[str, str]],
    control_frequency: float,
    episodes: int,
    seed: int,
    specs: Mapping[str, ControllerSpec] = FLOORS,
    engine: str = MUJOCO,
) -> list[FloorJob]:
    """The floors under every condition where they can be made.

    Args:
        conditions: environment ids and scenarios.
        control_frequency: control frequency of the environments [Hz].
        episodes: number of episodes of each job; a deterministic scenario has one.
        seed: seed of the first episode.
        specs: declared policies of which those are taken that can be made.
        engine: engine of the environments.
    """
    jobs = []
    for environment_id, scenario in conditions:
        with closing(make_environment(environment_id, scenario, control_frequency, engine)) as env:
            count = episodes_to_run(env, episodes)
            layout = env.get_wrapper_attr("observation_layout")
        names = [name for name, spec in specs.items() if not spec.missing_fields(layout)]
        jobs += [
            FloorJob(environment_id, scenario, name, control_frequency, count, seed, engine) for name in names
        ]
    return jobs
