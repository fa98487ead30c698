"""Tuned laws as files: what was found, with what, and how to make a policy of it."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from prp_gym.baselines import BASELINES, Baseline, ControlInterface, make_baseline
from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.scenario import SCENARIOS


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Mean scores on episodes that the search did not use, and that its budget does not count.

    Attributes:
        seed: of the first episode.
        episodes: how many.
        score: of the settings that were found [1].
        score_of_tuned: of the set from which the search started [1].
    """

    seed: int
    episodes: int
    score: float
    score_of_tuned: float


@dataclass(frozen=True, kw_only=True, eq=False)
class TunedController:
    """The settings of a law that a search with a budget has found, and how.

    Attributes:
        environment: id.
        controller: a baseline.
        scenario: of the training episodes.
        control_frequency: actions a second [Hz].
        settings: all of the law's but its model, as `make_baseline` takes them.
        budget_steps: control steps that might be simulated, of all environments together.
        used_steps: that were.
        simulated_seconds: what these are in simulated time [s].
        trials: candidates, the law's own `tuned` set first.
        episodes: that each of them played.
        seconds: that the search took [s].
        history: steps and best score so far, wherever it rose, and at the end.
        score: mean over the training episodes [1].
        score_of_tuned: of the first candidate, on the same episodes [1].
        validation: the same on other episodes.
        seed: of the search.
        command: that ran it.
        versions: of Python and of the packages that the result depends on.
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

    def make(self, env: Any) -> Baseline[Any]:
        """The law with the settings that were found, as a policy for its environment.

        Args:
            env: an environment of this suite, wrapped or not, or many alike; of any scenario.

        Raises:
            InvalidValueError: another environment, or another control frequency.
        """
        interface = ControlInterface.of(env)
        if interface.environment_id != self.environment:
            raise InvalidValueError("environment of a tuned law", interface.environment_id, self.environment)
        frequency = 1.0 / interface.period
        if not math.isclose(frequency, self.control_frequency):
            raise InvalidValueError("control_frequency", frequency, f"{self.control_frequency:g}", "Hz")
        return make_baseline(self.controller, env, "tuned", **self.settings)


def list_tuned_controllers(environment_id: str | None = None) -> list[str]:
    """Names of the tuned laws that come with this package, `<environment id>/<law>`.

    Args:
        environment_id: whose laws; all without it.

    Raises:
        UnknownNameError: an environment that does not exist.
    """
    if environment_id is None:
        return list(_shipped())
    if environment_id not in list_envs():
        raise UnknownNameError("environment", environment_id, list_envs())
    return [name for name in _shipped() if name.startswith(f"{environment_id}/")]


def load_tuned_controller(name_or_path: str | Path) -> TunedController:
    """A tuned law from a file.

    Args:
        name_or_path: a name of `list_tuned_controllers`, or a `result.json` of `prp-gym tune`.

    Raises:
        UnknownNameError: neither a name nor a file.
        InvalidValueError: a file that is not one of a tuned law; it says where.
    """
    path = _shipped().get(str(name_or_path), Path(name_or_path))
    if not path.is_file():
        raise UnknownNameError("tuned law", str(name_or_path), _shipped())
    try:
        content = json.loads(path.read_bytes(), parse_constant=_refuse_constant)
    except (OSError, ValueError, RecursionError) as error:
        raise InvalidValueError(f"file {str(path)!r}", str(error), "the JSON of a tuned law") from error
    return read_tuned_controller(content, f"file {str(path)!r}")


def read_tuned_controller(content: Any, where: str) -> TunedController:
    """A tuned law from what its file holds.

    Args:
        content: parsed JSON.
        where: it comes from, for errors.

    Raises:
        InvalidValueError: a field that is missing, too many, of another kind, or none that can be.
    """
    values = _read(TunedController, content, where)
    values["validation"] = Validation(**_read(Validation, values["validation"], f"validation of {where}"))
    for name, valid in (("environment", list_envs()), ("controller", BASELINES), ("scenario", SCENARIOS)):
        if values[name] not in valid:
            raise InvalidValueError(f"{name} of {where}", values[name], f"one of {', '.join(valid)}")
    values["history"] = _history(values["history"], where)
    try:
        BASELINES[values["controller"]].settings_class.from_mapping(values["controller"], values["settings"])
    except (PRPError, TypeError) as error:
        raise InvalidValueError(f"settings of {where}", values["settings"], str(error)) from error
    return TunedController(**values)


@cache
def _shipped() -> dict[str, Path]:
    """The files beside the baselines, by name."""
    folder = Path(str(files("prp_gym.baselines").joinpath("equal_budget")))
    return {
        f"{environment_id}/{controller}": path
        for environment_id in list_envs()
        for controller in BASELINES
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
    """The fields of a dataclass, no more and no less, with text and numbers of their types."""
    names = [entry.name for entry in fields(kind)]
    if not isinstance(content, dict) or set(content) != set(names):
        found = sorted(content) if isinstance(content, dict) else type(content).__name__
        raise InvalidValueError(where, found, f"exactly the fields {', '.join(names)}")
    for entry in fields(kind):
        value, allowed = content[entry.name], _KINDS.get(entry.type, (dict,))
        if isinstance(value, bool) or not isinstance(value, allowed):
            expected = " or ".join(item.__name__ for item in allowed)
            raise InvalidValueError(f"{entry.name} of {where}", value, expected)
    return dict(content)


def _history(rows: Sequence[Any], where: str) -> tuple[tuple[int, float], ...]:
    pairs = all(
        isinstance(row, list) and len(row) == 2 and type(row[0]) is int and type(row[1]) in (int, float)
        for row in rows
    )
    if not (rows and pairs):
        raise InvalidValueError(f"history of {where}", rows, "at least one pair of steps and score")
    return tuple((steps, float(score)) for steps, score in rows)


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is no number")
