"""How a controller is made for an environment, from its name or its declaration."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.described import Origin
from prp_gym.baselines.base.gains import Gains, GainSet, other_sets, read_gains, takes_target_impedance
from prp_gym.baselines.base.policy import Baseline
from prp_gym.baselines.base.settings import Settings
from prp_gym.baselines.base.spec import CONTROLLERS, TUNED, ControllerSpec, find_controller
from prp_gym.checks import instance
from prp_gym.errors import GainsFileError, InvalidValueError, MissingFieldError
from prp_gym.tasks.fields import ObservationLayout


def list_baselines(layout: ObservationLayout | None = None) -> list[str]:
    """Names of the controllers, or of those that can run on an environment's observations.

    Args:
        layout: `env.unwrapped.observation_layout`; all controllers without it.

    Raises:
        InvalidValueError: a value that is not a layout.
    """
    if layout is None:
        return list(CONTROLLERS)
    instance("layout", layout, ObservationLayout)
    return [name for name, spec in CONTROLLERS.items() if not spec.missing_fields(layout)]


def make_baseline(
    name: str | ControllerSpec, env: Any, gains: Gains = TUNED, **overrides: Any
) -> Baseline[Any]:
    """A controller as a policy for an environment.

    Args:
        name: name of the controller, as `list_baselines` gives it, or its declaration.
        env: an environment of this suite, wrapped or not, or a vector environment, Gymnasium's or
            Stable-Baselines3's; only its layout, limits and control frequency are read.
        gains: name of a gain set: `tuned`, `report`, or another that the controller has; a mapping of
            settings; or a path of a TOML file of settings, a `Path` or a text that ends in `.toml`. Beside
            settings, a mapping or file may hold a `source`, a `minimum_frequency` [Hz], and a table by
            environment id of what differs there.
        overrides: the controller's settings by name, in place of the set's. A call that overrides all
            gains is free to choose the control frequency.

    Returns:
        a policy whose `predict` takes observations of the environment.

    Raises:
        UnknownNameError: a controller, gain set or setting that does not exist.
        GainsFileError: a file of gains that cannot be read, is not TOML, or does not fit the controller.
        MissingFieldError: the environment does not observe what the controller reads.
        InvalidValueError: a setting that is not allowed or that is missing, gains that are unstable at the
            environment's control frequency, an environment of another suite, or one whose actions are not
            torques.
    """
    return make_controller(name, ControlInterface.of(env), gains, **overrides)


def make_controller(
    controller: str | ControllerSpec, interface: ControlInterface, gains: Gains = TUNED, **overrides: Any
) -> Baseline[Any]:
    """A controller on an interface; see `make_baseline`."""
    spec = find_controller(controller)
    chosen = read_gains(spec, gains, interface.environment_id)
    takes = takes_target_impedance(spec, gains)
    requested = _target_impedance(spec, interface, chosen.target_factor) if takes else {}
    given = {**chosen.values, **requested}
    chosen_gains = set(spec.settings_class.vectors) & set(given)
    if not chosen_gains <= set(overrides):
        _require_frequency(spec, chosen, 1.0 / interface.period, other_sets(spec, gains))
    settings = _make_settings(spec, chosen, given, overrides)
    try:
        made: Baseline[Any] = spec.policy(interface, settings)
    except MissingFieldError as error:  # by the name that its user knows
        raise MissingFieldError(spec.name, error.missing, error.available) from None
    made.origin = Origin(spec.name, chosen.label, tuple(overrides))
    return made


def _require_frequency(spec: ControllerSpec, chosen: GainSet, frequency: float, others: str) -> None:
    """Refuse gains that are unstable at a control frequency [Hz]."""
    frequency = round(frequency, 6)
    if frequency < chosen.minimum_frequency:
        raise InvalidValueError(
            "control_frequency",
            frequency,
            f"at least {chosen.minimum_frequency:g} with {chosen.label} of controller {spec.name!r},"
            f" which are unstable below it (other sets: {others})",
            "Hz",
        )


def _target_impedance(
    spec: ControllerSpec, interface: ControlInterface, factor: Mapping[str, Any]
) -> dict[str, Any]:
    """The target impedance of the task times the factors of the gains, by the settings that render it."""
    target = interface.target_impedance
    return {
        name: target[name] * np.asarray(factor.get(name, 1.0))
        for name in spec.policy.rendered
        if name in target
    }


def _make_settings(
    spec: ControllerSpec, chosen: GainSet, values: Mapping[str, Any], overrides: Mapping[str, Any]
) -> Settings:
    """The settings of a controller; a value that is refused is said to be the file's if it is.

    Raises:
        PRPError: see `make_baseline`.
    """
    try:
        return spec.settings_class.from_mapping(spec.name, {**values, **overrides})
    except InvalidValueError as error:
        if chosen.file is None or error.what in overrides:
            raise
        raise GainsFileError(chosen.file, str(error).removesuffix(".")) from error
