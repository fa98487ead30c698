"""`Selection`: the checked environments, scenarios and controllers of a command."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

from prp_gym.baselines import CONTROLLERS
from prp_gym.errors import CompilerError, InvalidValueError, UnknownNameError
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import EvaluationJob
from prp_gym.runs.user_code import UserCode
from prp_gym.symbolic.compiler import require_compiled_code
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.scenario import SCENARIOS


@dataclass(frozen=True)
class Selection:
    """Environments, scenarios and controllers that a command evaluates.

    Attributes:
        conditions: environment ids and scenarios.
        choices: controllers with their gains.
        controllers: source of the controllers.
        named: names of the controllers that the options name; empty if they name none.
        left_out: names of controllers that nobody has named and that are too slow on this machine.
    """

    conditions: tuple[tuple[str, str], ...]
    choices: tuple[ControllerChoice, ...]
    controllers: Controllers
    named: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        environments: Sequence[str],
        scenarios: Sequence[str],
        controllers: Sequence[str],
        gains: GainsChoice,
    ) -> Self:
        """The selection that options name; without names, all environments or controllers are selected.

        Args:
            environments: environment ids.
            scenarios: names of the scenarios.
            controllers: names of controllers, or a user's code as `path/to/file.py:Name` or
                `package.module:Name`.
            gains: gains of all controllers; without controllers, those that have the gain set are selected.

        Raises:
            UnknownNameError: a name or gain set that does not exist.
            InvalidValueError: two controllers under one name; a file that cannot be read.
            UserCodeError: a user's code that cannot be loaded.
        """
        ids = check_names("environment", environments, list_envs())
        names = [name for name in controllers if ":" not in name]
        codes = tuple(dict.fromkeys(UserCode.find(name) for name in controllers if ":" in name))
        _check_labels(codes)
        left_out: tuple[str, ...] = ()
        if not controllers:
            names = _with_set(gains)
            left_out = _too_slow(names)
            names = [name for name in names if name not in left_out]
        elif names:
            check_names("baseline", names, list(CONTROLLERS))
        known = check_names("scenario", scenarios, list(SCENARIOS))
        choices = [ControllerChoice(name, gains=gains) for name in dict.fromkeys(names)]
        choices += [ControllerChoice(code.label, code.sha256, gains) for code in codes]
        conditions = tuple(itertools.product(ids, known))
        table = Controllers(codes)
        for choice in choices:
            table.find(choice)
        named = tuple(choice.name for choice in choices) if controllers else ()
        return cls(conditions, tuple(choices), table, named, left_out)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a command says of the controllers that are left out."""
        return tuple(
            f"{name} is left out, since it is slow without compiled code; --baseline {name} runs it."
            for name in self.left_out
        )

    @property
    def environment_ids(self) -> list[str]:
        """Ids of the chosen environments."""
        return list(dict.fromkeys(environment_id for environment_id, _ in self.conditions))

    def check_used(self, jobs: Iterable[object]) -> None:
        """Refuse a controller that an option names and that runs on none of the environments.

        Raises:
            InvalidValueError: such a controller.
        """
        used = {job.controller.name for job in jobs if isinstance(job, EvaluationJob)}
        for name in self.named:
            if name not in used:
                allowed = f"a controller that runs on the chosen environments: {sorted(used)}"
                raise InvalidValueError("baseline", name, allowed)


def check_names(kind: str, names: Sequence[str], valid: Sequence[str]) -> list[str]:
    """The names without repetitions, or all valid ones for none.

    Raises:
        UnknownNameError: a name that is not valid.
    """
    for name in names:
        if name not in valid:
            raise UnknownNameError(kind, name, valid)
    return list(dict.fromkeys(names)) or list(valid)


def _with_set(gains: GainsChoice) -> list[str]:
    """The registered controllers that have a gain set; all of them for a file."""
    if gains.toml:
        return list(CONTROLLERS)
    found = [name for name, spec in CONTROLLERS.items() if gains.name in spec.gain_sets]
    if not found:
        known = {item for spec in CONTROLLERS.values() for item in spec.gain_sets}
        raise UnknownNameError("gain set", gains.name, known)
    return found


def _too_slow(names: Sequence[str]) -> tuple[str, ...]:
    """The controllers that take far longer on this machine, which has no compiled code, than on others."""
    try:
        require_compiled_code()
    except CompilerError:
        return tuple(name for name in names if CONTROLLERS[name].policy.slow_without_compiler)
    return ()


def _check_labels(codes: Sequence[UserCode]) -> None:
    labels = [code.label for code in codes]
    for label in labels:
        if labels.count(label) > 1:
            raise InvalidValueError("baseline", label, "one that no other controller of this command has")
