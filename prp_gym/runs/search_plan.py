"""The searches of `prp-gym tune-all`: every controller on every environment for which it is intended."""

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path

from prp_gym.agents.policy.agent_file import list_agents, load_agent
from prp_gym.baselines import CONTROLLERS
from prp_gym.errors import InvalidValueError, PRPError
from prp_gym.runs.choice import TUNED, ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.search import Search
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning.task import EPISODES, TuningTask
from prp_gym.tuning.tuned_controller import TunedController

SCENARIOS = ("realistic", "randomized")
"""Scenarios over whose mean scores controllers are tuned unless others are named."""

FREQUENCY = 500.0
"""Control frequency at which controllers are tuned [Hz]."""

SECONDS_WITHOUT_AGENT = 5000.0
"""Simulated time of a search on an environment for which there is no agent in the package [s]."""


def list_combinations(environment_ids: Sequence[str], controllers: Sequence[str]) -> list[tuple[str, str]]:
    """Environments with the controllers that are intended for them.

    Args:
        environment_ids: ids of the environments to choose from; all if there are none.
        controllers: names of the controllers to choose from; all if there are none.

    Raises:
        UnknownNameError: a controller that does not exist.
        InvalidValueError: none of the controllers is intended for any of the environments.
    """
    specs = [CONTROLLERS.find(name) for name in controllers or CONTROLLERS]
    ids = list(environment_ids or list_envs())
    combinations = [(name, spec.name) for name in ids for spec in specs if name in spec.data.intended]
    if not combinations:
        intended = {spec.name: list(spec.data.intended) for spec in specs}
        raise InvalidValueError("environments", ids, f"at least one of those intended, {intended}")
    return combinations


@cache
def simulated_seconds(environment_id: str) -> Fraction:
    """The longest simulated training time of an agent of the package on an environment [s]."""
    cards = [load_agent(name).card for name in list_agents(environment_id)]
    times = [Fraction(card.steps) / Fraction(card.control_frequency) for card in cards]
    return max(times, default=Fraction(SECONDS_WITHOUT_AGENT))


def plan_search(
    combination: tuple[str, str],
    budget: int | None,
    scale: float,
    seed: int,
    output: Path,
    command: str,
    resume: bool = True,
    engine: str = MUJOCO,
) -> Search:
    """The search for the gains of a controller on an environment.

    Args:
        combination: environment id and name of the controller.
        budget: control steps that may be simulated; None for the simulated training time of an agent.
        scale: share of the budget that is spent.
        seed: seed of the search.
        output: folder for the folder of the search.
        command: command line that runs the search.
        resume: whether to go on with what an interrupted run has kept, in place of starting over.
        engine: engine of the environment.

    Raises:
        InvalidValueError: a budget that is too small.
    """
    environment_id, name = combination
    steps = simulated_seconds(environment_id) * Fraction(FREQUENCY) if budget is None else Fraction(budget)
    task = TuningTask(
        *(environment_id, name, SCENARIOS, FREQUENCY, math.floor(steps * Fraction(scale))),
        *(EPISODES, seed, engine),
    )
    return Search(task, ControllerChoice(name, gains=GainsChoice(TUNED)), output, command, resume)


def run_or_fail(search: Search) -> TunedController | PRPError:
    """The result of a search, or the reason for which it failed, so that others go on."""
    try:
        return search.run(Controllers())
    except PRPError as error:
        return error
