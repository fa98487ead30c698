"""Controllers of a command, registered or a user's own, made for environments in any process."""

import inspect
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from typing import Any

import gymnasium
import numpy as np

from prp_gym.baselines import CONTROLLERS, Baseline, ControllerSpec, make_baseline
from prp_gym.errors import GainsFileError, InvalidValueError, UnknownNameError, UserCodeError
from prp_gym.evaluation.policy_output import check_output
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.choice import TUNED, ControllerChoice, GainsChoice
from prp_gym.runs.predictor import Predictor
from prp_gym.runs.user_code import UserCode, definition, report_failed_acting, report_failed_making

Controller = ControllerSpec | Predictor


@dataclass(frozen=True)
class Controllers:
    """Source of the controllers of a command.

    Attributes:
        codes: users' code that the command line names; handed to worker processes, never stored.
    """

    codes: tuple[UserCode, ...] = ()

    def find(self, choice: ControllerChoice) -> Controller:
        """The declaration of a controller.

        Raises:
            UnknownNameError: a controller that is not registered, or code that was not given.
            UserCodeError: a user's code that cannot be loaded, or that defines no controller.
        """
        if not choice.sha256:
            return CONTROLLERS.find(choice.name)
        for code in self.codes:
            if (code.label, code.sha256) == (choice.name, choice.sha256):
                return _declaration(code)
        raise UnknownNameError("controller of a user", choice.name, [code.label for code in self.codes])

    def runs_on(self, choice: ControllerChoice, env: gymnasium.Env[Any, Any]) -> bool:
        """Whether an environment observes what a controller reads; always true for a class with `predict`."""
        controller = self.find(choice)
        if isinstance(controller, Predictor):
            return True
        return not controller.missing_fields(env.get_wrapper_attr("observation_layout"))

    def make(self, choice: ControllerChoice, env: gymnasium.Env[Any, Any]) -> Policy:
        """A controller with its gains as a policy for an environment.

        Raises:
            UnknownNameError: a gain set or setting that the controller does not have.
            GainsFileError: a file that does not fit the controller.
            InvalidValueError: a setting that is not allowed, or gains that are unstable at the control
                frequency.
            UserCodeError: a user's code that fails.
        """
        controller = self.find(choice)
        if isinstance(controller, Predictor):
            values = {**predictor_gains(controller, choice.gains), **choice.gains.overrides}
            return _construct(controller, env, values)
        return _make(controller, choice.gains, env)

    def make_with(self, choice: ControllerChoice, env: Any, values: Mapping[str, Any]) -> Policy:
        """A controller with all its settings given, in place of its gains.

        Args:
            choice: controller with its gains.
            env: environment for which the controller is made.
            values: settings by name.

        Raises:
            PRPError: settings that the controller refuses.
        """
        controller = self.find(choice)
        if isinstance(controller, Predictor):
            return _construct(controller, env, values)
        with report_failed_making(controller.policy, environment_id(env)):
            return make_baseline(controller, env, **values)

    def try_out(self, choice: ControllerChoice, env: gymnasium.Env[Any, Any]) -> Policy:
        """Make a controller and, if it is a user's, request one action, so that faults are found early.

        Raises:
            PRPError: see `make`.
            UserCodeError: `predict` fails, or returns something else than a finite action and a state.
        """
        policy = self.make(choice, env)
        if choice.sha256:
            observation, _ = env.reset(seed=0)
            with self.reported(choice, env):
                output = policy.predict(observation, None, np.array([True]), True)
                check_output(policy, output, tuple(env.action_space.shape or ()))
        return policy

    def reported(self, choice: ControllerChoice, env: Any) -> AbstractContextManager[None]:
        """A context in which failing code of a user's is reported as `UserCodeError`."""
        return report_failed_acting(policy_class(self.find(choice)), environment_id(env))


def settings_of(controller: Controller, choice: ControllerChoice, policy: Any) -> dict[str, Any]:
    """The settings with which a policy was made, for its record."""
    if isinstance(controller, Predictor):
        given = {**predictor_gains(controller, choice.gains), **choice.gains.overrides}
        return {"gains": choice.gains.name, **controller.defaults, **given}
    return {"gains": choice.gains.name, **vars(policy.settings)}


def gain_sets_of(controller: Controller) -> tuple[str, ...]:
    """Names of the gain sets of a controller."""
    return (TUNED,) if isinstance(controller, Predictor) else controller.gain_sets


def policy_class(controller: Controller) -> type[Any]:
    """The class of a controller's policies."""
    return controller.kind if isinstance(controller, Predictor) else controller.policy


def environment_id(env: Any) -> str:
    """Id of an environment of this suite."""
    return str(env.unwrapped.task.environment_id)


def predictor_gains(controller: Predictor, gains: GainsChoice) -> dict[str, Any]:
    """Settings of a class with `predict` by name; its only gain set, `tuned`, is its defaults.

    Raises:
        UnknownNameError: another gain set.
    """
    values = gains.values
    if isinstance(values, str):
        if values != TUNED:
            raise UnknownNameError(f"gain set of controller {controller.name!r}", values, (TUNED,))
        return {}
    return {name: value for name, value in values.items() if name != "source"}


def _construct(controller: Predictor, env: Any, values: Mapping[str, Any]) -> Policy:
    with report_failed_making(controller.kind, environment_id(env)):
        return controller.make(env, values)


def _make(spec: ControllerSpec, gains: GainsChoice, env: Any) -> Policy:
    """A controller by its declaration; a setting that a file gives wrongly is said to be the file's."""
    try:
        with report_failed_making(spec.policy, environment_id(env)):
            return make_baseline(spec, env, gains.values, **gains.overrides)
    except (UnknownNameError, InvalidValueError) as error:
        if not gains.toml or getattr(error, "name", "") in gains.overrides:
            raise
        raise GainsFileError(gains.name, str(error).removesuffix(".")) from error


@cache
def _declaration(code: UserCode) -> Controller:
    """What a user's code declares under its name.

    Raises:
        UserCodeError: neither a declaration nor a class of policies.
    """
    found = code.load()
    if isinstance(found, ControllerSpec):
        return found
    if inspect.isclass(found) and issubclass(found, Baseline):
        return ControllerSpec(name=code.attribute, summary=code.label, policy=found)
    if inspect.isclass(found) and callable(getattr(found, "predict", None)):
        return Predictor(code.label, found)
    allowed = "a ControllerSpec, a function with @prp_gym.controller, or a class with `predict`"
    file, line = definition(found, code.source)
    raise UserCodeError(file, line, f"{code.attribute!r} is {type(found).__name__}; it must be {allowed}")
