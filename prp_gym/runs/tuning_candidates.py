"""What `prp-gym tune` searches: the candidates for a controller that the command line names."""

from dataclasses import replace
from typing import Any

import gymnasium

from prp_gym.baselines import CONTROLLERS
from prp_gym.errors import UnknownNameError
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers, settings_of
from prp_gym.runs.predictor import Predictor
from prp_gym.runs.user_code import UserCode
from prp_gym.tuning import Candidates, SearchSpace, start_gains
from prp_gym.tuning.keyword_space import KeywordSpace


def choose_controller(name: str, gains: GainsChoice) -> tuple[ControllerChoice, Controllers]:
    """A controller by its name, or a user's own by its code.

    Args:
        name: registered name, or `path/to/file.py:Name` or `package.module:Name`.
        gains: gains from which the search starts.

    Raises:
        UnknownNameError: a name that does not exist.
        InvalidValueError: a file that cannot be read.
        UserCodeError: a user's code that cannot be loaded.
    """
    if ":" not in name:
        if name not in CONTROLLERS:
            raise UnknownNameError("baseline", name, CONTROLLERS)
        return ControllerChoice(name, gains=gains), Controllers()
    code = UserCode.find(name)
    return ControllerChoice(code.label, code.sha256, gains), Controllers((code,))


def with_start_gains(
    choice: ControllerChoice, controllers: Controllers, environment_id: str, control_frequency: float
) -> ControllerChoice:
    """The same controller with the gain set from which a search of it starts on an environment."""
    declared = controllers.find(choice)
    if isinstance(declared, Predictor):
        return choice
    name = start_gains(declared, environment_id, control_frequency)
    return replace(choice, gains=replace(choice.gains, name=name))


def list_candidates(
    choice: ControllerChoice, controllers: Controllers, env: gymnasium.Env[Any, Any]
) -> Candidates:
    """The candidates around the gains of a controller, which is tried out first.

    Args:
        choice: the controller with the gains from which the search starts.
        controllers: source of the controller.
        env: environment on which the controller is tuned.

    Raises:
        PRPError: a controller that cannot run on the environment with these gains.
    """
    declared = controllers.find(choice)
    start: Any = controllers.try_out(choice, env)
    if isinstance(declared, Predictor):
        settings = settings_of(declared, choice, start)
        del settings["gains"]
        return Candidates(KeywordSpace(settings), lambda values: controllers.make_with(choice, env, values))
    space = SearchSpace.of(declared, start.settings)
    return Candidates(space, lambda values: controllers.make_with(choice, env, values))
