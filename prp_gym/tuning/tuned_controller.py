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


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Mean scores on episodes that the search did not use, and that its budget does not count.

    Attributes:
        seed: seed of the first episode.
        episodes: number of episodes.
        score: score of the settings that were found [1].
        score_of_tuned: score of the gains from which the search started [1].
    """

    seed: int
    episodes: int
    score: float
    score_of_tuned: float


@dataclass(frozen=True, kw_only=True, eq=False)
class TunedController:
    """The settings of a controller that a search with a budget has found, and how.

    Attributes:
        environment: id of the environment.
        controller: name of the controller.
        scenario: scenario of the training episodes.
        control_frequency: control frequency of the environment [Hz].
        settings: all settings of the controller but its model, as `make_baseline` takes them.
        budget_steps: control steps that the search was allowed, of all environments together.
        used_steps: control steps that were simulated.
        simulated_seconds: simulated time of these steps [s].
        trials: number of candidates; the first has the gains from which the search started.
        episodes: number of episodes of each candidate.
        seconds: wall time of the search [s].
        history: control steps and best score so far, wherever it rose, and at the end.
        score: mean score over the training episodes [1].
        score_of_tuned: mean score of the first candidate, on the same episodes [1].
        validation: scores of the same settings on other episodes.
        seed: seed of the search.
        command: command line that ran the search.
        versions: versions of Python and of the packages that the result depends on.
        code: name and SHA-256 of a user's controller; empty for a registered one.
    """

    environment: str
    controller: str
    scenario: str
    control_frequency: float
    settings: Mapping[str, Any]
    budget_steps: int
    used_steps: int
    simulated_seconds: float
    trials: int
    episodes: int
    seconds: float
    history: tuple[tuple[int, float], ...]
    score: float
    score_of_tuned: float
    validation: Validation
    seed: int
    command: str
    versions: Mapping[str, str]
    code: Mapping[str, str] = field(default_factory=dict)

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
    valid: dict[str, Iterable[str]] = {"environment": list_envs(), "scenario": SCENARIOS}
    if not found.code:
        valid["controller"] = CONTROLLERS
    for name, names in valid.items():
        if getattr(found, name) not in names:
            raise UnknownNameError(name, getattr(found, name), names)
    if not found.history:
        raise InvalidValueError("history", found.history, "at least one row of steps and score")
    if not found.code:
        kind = CONTROLLERS.find(found.controller).settings_class
        kind.from_mapping(found.controller, found.settings)


@cache
def _shipped() -> dict[str, Path]:
    """The files beside the baselines, by name."""
    folder = Path(str(files("prp_gym.baselines").joinpath("equal_budget")))
    return {
        f"{environment_id}/{controller}": path
        for environment_id in list_envs()
        for controller in CONTROLLERS
        if (path := folder / f"{environment_id}_{controller}.json").is_file()
    }
