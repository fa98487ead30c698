"""Tuned controllers as files: the settings that a search found, and the policies made from them."""

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from prp_gym.baselines import CONTROLLERS, Baseline, ControlInterface, make_baseline
from prp_gym.errors import DataFileError, InvalidValueError, PRPError, UnknownNameError
from prp_gym.files.checksum import unseal_or_former
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.files.typed_reader import TypedReader
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tasks.setup import ENGINES, MUJOCO
from prp_gym.tuning.task import METHODS, SAMPLING
from prp_gym.tuning.validation import Validation

SEARCHES = "searches"
"""Folder of the package, beside the controllers, with the records of the searches for their `tuned` gains."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TunedController:
    """The settings of a controller that a search with a budget has found, and how.

    Attributes:
        environment: id of the environment.
        controller: name of the controller.
        scenarios: scenarios of the training episodes.
        control_frequency: control frequency of the environment [Hz].
        settings: all settings of the controller but its model, as `make_baseline` takes them.
        budget_steps: control steps that the search was allowed, of all environments together, without the
            share that is added where the best candidate lies at an edge.
        used_steps: control steps that were simulated.
        simulated_seconds: simulated time of these steps [s].
        trials: number of candidates; the first has the gains from which the search started.
        episodes: number of training episodes of each candidate, of all scenarios together.
        seconds: wall time of the search, without that of the validation [s].
        history: control steps and best score so far, wherever it rose, and at the end.
        history_by_scenario: scores of the same candidates in each scenario [1].
        score: mean score of the settings over the training episodes, before they were rounded [1].
        score_of_start: mean score of the first candidate, on the same episodes [1].
        edges: reasons for which the best candidate of the search lies at an edge of its range, by parameter
            and end; a declared limit, or that it is none.
        validation: scores on other episodes, from which the settings were chosen.
        seed: seed of the search.
        command: command line that ran the search.
        versions: versions of Python and of the packages that the result depends on.
        code: name and SHA-256 of a user's controller; empty for a registered one.
        engine: engine of the search and of its validation; MuJoCo in a file that names none.
        method: method of the search; `sampling` in a file that names none.
    """

    environment: str
    controller: str
    scenarios: tuple[str, ...]
    control_frequency: float
    settings: Mapping[str, Any]
    budget_steps: int
    used_steps: int
    simulated_seconds: float
    trials: int
    episodes: int
    seconds: float
    history: tuple[tuple[int, float], ...]
    history_by_scenario: Mapping[str, tuple[float, ...]]
    score: float
    score_of_start: float
    edges: Mapping[str, str]
    validation: Validation
    seed: int
    command: str
    versions: Mapping[str, str]
    code: Mapping[str, str] = field(default_factory=dict)
    engine: str = MUJOCO
    method: str = SAMPLING

    def make(self, env: Any) -> Baseline[Any]:
        """The controller with the settings that were found, as a policy for its environment.

        Args:
            env: an environment of this suite, wrapped or not, or a vector environment; of any scenario.

        Raises:
            InvalidValueError: another environment or control frequency, or a controller of a user's own.
        """
        if self.code:
            allowed = "a registered controller; a user's own is made with these settings by its own code"
            raise InvalidValueError("tuned controller", self.controller, allowed)
        interface = ControlInterface.of(env)
        if interface.environment_id != self.environment:
            raise InvalidValueError(
                "environment of a tuned controller", interface.environment_id, self.environment
            )
        frequency = 1.0 / interface.period
        if not math.isclose(frequency, self.control_frequency):
            raise InvalidValueError("control_frequency", frequency, f"{self.control_frequency:g}", "Hz")
        return make_baseline(self.controller, env, "tuned", **self.settings)


def list_tuned_controllers(environment_id: str | None = None) -> list[str]:
    """Names of the tuned controllers that come with this package, `<environment id>/<controller>`.

    Args:
        environment_id: id of the environment; None for all.

    Raises:
        UnknownNameError: an environment that does not exist.
    """
    if environment_id is None:
        return list(_shipped())
    if environment_id not in list_envs():
        raise UnknownNameError("environment", environment_id, list_envs())
    return [name for name in _shipped() if name.startswith(f"{environment_id}/")]


def load_tuned_controller(name_or_path: str | Path) -> TunedController:
    """A tuned controller from a file.

    Args:
        name_or_path: a name of `list_tuned_controllers`, or a `result.json` of `prp-gym tune`.

    Raises:
        UnknownNameError: neither a name nor a file.
        DataFileError: a file that does not hold a tuned controller; it says where.
    """
    path = _shipped().get(str(name_or_path), Path(name_or_path))
    if not os.path.exists(path) or os.path.isdir(path):
        raise UnknownNameError("tuned controller", str(name_or_path), _shipped())
    content = unseal_or_former(path, FileReader(RECORD_SIZE).read_json(path))
    return read_tuned_controller(content, path)


def read_tuned_controller(content: Any, path: Path) -> TunedController:
    """A tuned controller from the content of its file.

    Args:
        content: content of the file as parsed JSON, without its checksum.
        path: path of the file, for messages.

    Raises:
        DataFileError: a field that is missing, unknown, of another type, or not allowed.
    """
    found = TypedReader(path).read(TunedController, content, "")
    try:
        _check(found)
    except (PRPError, TypeError) as error:
        raise DataFileError(path, str(error).removesuffix(".")) from error
    return found


def _check(found: TunedController) -> None:
    """Refuse names that are not declared, and settings that the controller refuses."""
    named: list[tuple[str, str, Iterable[str]]] = [("environment", found.environment, list_envs())]
    named += [("engine", found.engine, ENGINES), ("method", found.method, METHODS)]
    named += [("scenario", scenario, SCENARIOS) for scenario in found.scenarios]
    if not found.code:
        named.append(("controller", found.controller, CONTROLLERS))
    for what, name, names in named:
        if name not in names:
            raise UnknownNameError(what, name, names)
    if not found.history:
        raise InvalidValueError("history", found.history, "at least one row of steps and score")
    rows = {name: len(scores) for name, scores in found.history_by_scenario.items()}
    expected = dict.fromkeys(found.scenarios, len(found.history))
    if rows != expected:
        raise InvalidValueError("rows of history_by_scenario", rows, f"as many as in history, {expected}")
    if not found.code:
        kind = CONTROLLERS.find(found.controller).settings_class
        kind.from_mapping(found.controller, found.settings)


@cache
def _shipped() -> dict[str, Path]:
    """The files beside the baselines, by name."""
    folder = Path(str(files("prp_gym.baselines").joinpath(SEARCHES)))
    return {
        f"{environment_id}/{controller}": path
        for environment_id in list_envs()
        for controller in CONTROLLERS
        if (path := folder / f"{environment_id}_{controller}.json").is_file()
    }
