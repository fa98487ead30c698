"""The settings that a gain set, a mapping or a file gives a controller on an environment."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from prp_gym.baselines.base.spec import ControllerSpec, find_controller, read_toml
from prp_gym.checks import finite
from prp_gym.errors import GainsFileError, InvalidValueError, PRPError, UnknownNameError
from prp_gym.tasks.registration import list_envs

Gains = str | Path | Mapping[str, Any]
"""A set's name, settings by name, or a TOML file of settings by name."""

SOURCE, MINIMUM_FREQUENCY, TARGET_FACTOR = "source", "minimum_frequency", "target_factor"


@dataclass(frozen=True, eq=False)
class GainSet:
    """Settings of a controller on one environment.

    Attributes:
        label: origin of the settings, as messages name it.
        values: settings by name.
        minimum_frequency: control frequency below which the gains are unstable [Hz].
        file: path of the user's file of gains; None for a gain set of the suite.
        target_factor: factors on the task's target impedance, by the settings that take it, one number or
            one for each axis; 1 for a setting that is missing.
    """

    label: str
    values: Mapping[str, Any]
    minimum_frequency: float = 0.0
    file: Path | None = None
    target_factor: Mapping[str, Any] = field(default_factory=dict)


def gain_sets(controller: str | ControllerSpec) -> tuple[str, ...]:
    """Names of a controller's gain sets.

    Raises:
        UnknownNameError: no such controller.
    """
    return find_controller(controller).gain_sets


def load_gains(controller: str | ControllerSpec, name: str, environment_id: str) -> dict[str, Any]:
    """A gain set of a controller on an environment.

    Args:
        controller: name or declaration of the controller.
        name: name of the gain set.
        environment_id: id of the environment, whose own values replace those of the set.

    Returns:
        settings by name, with the set's `source`.

    Raises:
        UnknownNameError: no such controller or set.
    """
    spec = find_controller(controller)
    if name not in spec.gain_sets:
        raise UnknownNameError(f"gain set of controller {spec.name!r}", name, spec.gain_sets)
    return _on(environment_id, spec.data.gains.get(name, {SOURCE: "defaults of the settings"}))


def read_gains(controller: ControllerSpec, gains: Gains, environment_id: str) -> GainSet:
    """The settings that gains of any kind give on an environment.

    Args:
        controller: declaration of the controller.
        gains: name of a gain set; a mapping of settings; or a path of a TOML file of settings, a `Path` or a
            text that ends in `.toml`. Beside settings, a mapping or file may hold a `source`, a
            `minimum_frequency` [Hz], and tables by environment id with the settings that differ there.
        environment_id: id of the environment.

    Raises:
        UnknownNameError: no such set; a mapping with a setting or an environment that does not exist.
        GainsFileError: a file that cannot be read, is not TOML, or names a setting or an environment that
            does not exist.
        InvalidValueError: gains of another type; a minimum frequency that is not a number.
    """
    if isinstance(gains, Mapping):
        _require_known(controller, gains)
        return _gain_set("these gains", gains, environment_id, None)
    if isinstance(gains, Path) or (isinstance(gains, str) and gains.endswith(".toml")):
        return _from_file(controller, Path(gains), environment_id)
    if not isinstance(gains, str):
        allowed = "a gain set's name, a mapping of settings, or the path of a TOML file"
        raise InvalidValueError(f"gains of controller {controller.name!r}", gains, allowed)
    content = load_gains(controller, gains, environment_id)
    return _gain_set(f"gains {gains!r}", content, environment_id, None)


def other_sets(controller: ControllerSpec, gains: Gains) -> str:
    """The gain sets that might be used instead, for messages."""
    return ", ".join(name for name in controller.gain_sets if name != gains) or "none"


def takes_target_impedance(controller: ControllerSpec, gains: Gains) -> bool:
    """Whether a task's target impedance replaces the numbers of these gains."""
    return isinstance(gains, str) and gains in controller.data.target_impedance_sets


def _from_file(controller: ControllerSpec, file: Path, environment_id: str) -> GainSet:
    content = read_toml(file)
    try:
        _require_known(controller, content)
        return _gain_set(f"gains of {str(file)!r}", content, environment_id, file)
    except (UnknownNameError, InvalidValueError) as error:
        raise GainsFileError(file, str(error).removesuffix(".")) from error


def _require_known(controller: ControllerSpec, content: Mapping[str, Any]) -> None:
    """Refuse names that are neither settings nor, for a table, environments."""
    tables = {name: value for name, value in content.items() if isinstance(value, Mapping)}
    for name in tables:
        if name not in list_envs():
            raise UnknownNameError("environment", name, list_envs())
    known = [entry.name for entry in fields(controller.settings_class)]
    for name in [*(name for name in content if name not in tables), *(n for t in tables.values() for n in t)]:
        if name not in (*known, SOURCE, MINIMUM_FREQUENCY):
            raise UnknownNameError(f"setting of controller {controller.name!r}", name, known)


def _gain_set(label: str, content: Mapping[str, Any], environment_id: str, file: Path | None) -> GainSet:
    values = _on(environment_id, content)
    values.pop(SOURCE, None)
    factor: Mapping[str, Any] = values.pop(TARGET_FACTOR, {})
    least = values.pop(MINIMUM_FREQUENCY, 0.0)
    try:
        frequency = float(finite(MINIMUM_FREQUENCY, least, "Hz"))
    except (PRPError, TypeError):  # no number, not a finite one, or several
        raise InvalidValueError(MINIMUM_FREQUENCY, least, "a finite number", "Hz") from None
    return GainSet(label, values, frequency, file, factor)


def _on(environment_id: str, content: Mapping[str, Any]) -> dict[str, Any]:
    """The common values, with an environment's own in their place where it has some."""
    own: Mapping[str, Any] = content.get(environment_id, {})
    common = {
        key: value
        for key, value in content.items()
        if key == TARGET_FACTOR or not isinstance(value, Mapping)  # which are those of environments
    }
    try:
        return deepcopy({**common, **own})
    except Exception as error:  # objects that cannot be copied are no settings
        raise InvalidValueError("gains", content, "names with numbers or words") from error
