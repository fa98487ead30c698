"""Tuned controllers as files: the settings that a search found, and the policies made from them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from prp_gym.artifacts import read_json
from prp_gym.baselines import CONTROLLERS, Baseline, ControlInterface, make_baseline
from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError
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
        InvalidValueError: a file that does not hold a tuned controller; it says where.
    """
    path = _shipped().get(str(name_or_path), Path(name_or_path))
    if not path.is_file():
        raise UnknownNameError("tuned controller", str(name_or_path), _shipped())
    return read_tuned_controller(read_json(path), f"file {str(path)!r}")


def read_tuned_controller(content: Any, where: str) -> TunedController:
    """A tuned controller from the content of its file.

    Args:
        content: content of the file as parsed JSON.
        where: origin of the content, for errors.

    Raises:
        InvalidValueError: a field that is missing, unknown, of another type, or not allowed.
    """
    values = _read(TunedController, content, where)
    values["validation"] = Validation(**_read(Validation, values["validation"], f"validation of {where}"))
    valid = {"environment": list_envs(), "scenario": list(SCENARIOS)}
    if not values.get("code"):
        valid["controller"] = list(CONTROLLERS)
    for name, names in valid.items():
        if values[name] not in names:
            raise InvalidValueError(f"{name} of {where}", values[name], f"one of {', '.join(names)}")
    values["history"] = _history(values["history"], where)
    if not values.get("code"):
        _check_settings(values["controller"], values["settings"], where)
    return TunedController(**values)


def _check_settings(controller: str, settings: Mapping[str, Any], where: str) -> None:
    try:
        CONTROLLERS.find(controller).settings_class.from_mapping(controller, settings)
    except (PRPError, TypeError) as error:
        raise InvalidValueError(f"settings of {where}", settings, str(error)) from error


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


_KINDS: Mapping[Any, tuple[type, ...]] = {
    str: (str,),
    int: (int,),
    float: (int, float),
    tuple[tuple[int, float], ...]: (list,),
}
"""What JSON has for a field's type; an object for every other type."""


def _read(kind: type[Any], content: Any, where: str) -> dict[str, Any]:
    """The fields of a dataclass, none unknown and none missing without a default, of their types."""
    names = {entry.name for entry in fields(kind)}
    needed = {entry.name for entry in fields(kind) if entry.default_factory is MISSING}
    if not isinstance(content, dict) or not needed <= set(content) <= names:
        found = sorted(content) if isinstance(content, dict) else type(content).__name__
        raise InvalidValueError(where, found, f"exactly the fields {', '.join(sorted(names))}")
    for entry in (entry for entry in fields(kind) if entry.name in content):
        value, allowed = content[entry.name], _KINDS.get(entry.type, (dict,))
        if isinstance(value, bool) or not isinstance(value, allowed):
            expected = " or ".join(item.__name__ for item in allowed)
            raise InvalidValueError(f"{entry.name} of {where}", value, expected)
    return dict(content)


def _history(rows: Sequence[Any], where: str) -> tuple[tuple[int, float], ...]:
    valid = all(
        isinstance(row, list) and len(row) == 2 and type(row[0]) is int and type(row[1]) in (int, float)
        for row in rows
    )
    if not (rows and valid):
        raise InvalidValueError(f"history of {where}", rows, "at least one row of steps and score")
    return tuple((steps, float(score)) for steps, score in rows)
