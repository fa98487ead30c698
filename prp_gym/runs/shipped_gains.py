"""The result of a search as a gain set of its controller, and the record of the search."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from prp_gym.artifacts import write_file
from prp_gym.baselines import CONTROLLERS, ControlInterface, ControllerSpec
from prp_gym.baselines.base.gains import MINIMUM_FREQUENCY, SOURCE, TARGET_FACTOR
from prp_gym.baselines.base.spec import TUNED
from prp_gym.errors import DataFileError, GainsFileError, InvalidValueError
from prp_gym.files.file_reader import SETTINGS_SIZE, FileReader
from prp_gym.files.toml_table import replace_table
from prp_gym.files.toml_text import parse_toml
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning.task import EPISODES, FINAL_EPISODES, SAMPLING
from prp_gym.tuning.tuned_controller import SEARCHES, TunedController, load_tuned_controller

_DIGITS = 6  # of a factor on the target impedance: with it, settings are those validated within 5e-7


@dataclass(frozen=True)
class Shipped:
    """What became of the result of a search.

    Attributes:
        tuned: result of the search.
        gains: data file of the controller; None where the start was kept, so that nothing was written.
        record: path of the record of the search in the package.
    """

    tuned: TunedController
    gains: Path | None
    record: Path


def searches_folder() -> Path:
    """The folder of the package with the records of searches."""
    return Path(str(files("prp_gym.baselines"))) / SEARCHES


def ship_result(result: Path, env: gymnasium.Env[Any, Any], folder: Path) -> Shipped:
    """Write the settings of a result into the data file of its controller, and keep the record of the search.

    The settings become the controller's set `tuned` on the environment of the search; comments and other sets
    stay as they are. Where the search kept its start, the data file stays as it is.

    Args:
        result: path of a `result.json` of `prp-gym tune`.
        env: environment of the search.
        folder: folder for the record.

    Raises:
        DataFileError: a damaged result, or a data file that cannot take the gains.
        InvalidValueError: a controller without a data file, an environment of another result.
        OutputError: a file that cannot be written.
    """
    tuned = load_tuned_controller(result)
    spec = CONTROLLERS.find(tuned.controller)
    file = spec.data.file
    if file is None or tuned.code:
        raise InvalidValueError("controller to ship", tuned.controller, "one with a data file of gains")
    tuned.make(env)  # refuses an environment that is not that of the search
    record = folder / f"{tuned.environment}_{tuned.controller}.json"
    if not tuned.validation.kept_start:
        _write_set(file, tuned, gain_table(spec, tuned, ControlInterface.of(env)))
    write_file(record, result.read_bytes())
    return Shipped(tuned, None if tuned.validation.kept_start else file, record)


def gain_table(spec: ControllerSpec, tuned: TunedController, interface: ControlInterface) -> dict[str, Any]:
    """The values of a gain set on one environment, without those that the set has for all.

    Settings that take the task's target impedance are factors on it.

    Args:
        spec: declaration of the controller.
        tuned: result of the search.
        interface: interface of the environment.
    """
    common = {key: value for key, value in spec.data.gains[TUNED].items() if not isinstance(value, Mapping)}
    target: Mapping[str, Any] = {}
    if TUNED in spec.data.target_impedance_sets:
        target = {name: interface.target_impedance[name] for name in _rendered(spec, interface)}
    table: dict[str, Any] = {}
    factors: dict[str, Any] = {}
    for name, value in tuned.settings.items():
        if name in target:
            factor = _factor(value, target[name])
            if factor != 1.0:
                factors[name] = factor
        elif not _equal(value, _usual(spec, common, name)):
            table[name] = _plain(value)
    if factors:
        table[TARGET_FACTOR] = factors
    if common.get(MINIMUM_FREQUENCY) != tuned.control_frequency:
        table[MINIMUM_FREQUENCY] = tuned.control_frequency
    return {**table, SOURCE: source_of(tuned)}


def source_of(tuned: TunedController) -> str:
    """The search that found the gains, and its validation, in a sentence."""
    checked = tuned.validation
    options = "" if tuned.engine == MUJOCO else f" --engine {tuned.engine}"
    if tuned.episodes != EPISODES:
        options += f" --episodes {tuned.episodes}"
    if tuned.validation.episodes != FINAL_EPISODES:
        options += f" --final-episodes {tuned.validation.episodes}"
    options += "" if tuned.method == SAMPLING else f" --method {tuned.method}"
    scenarios = " and ".join(tuned.scenarios)
    return (
        f"prp-gym tune {tuned.controller} --env {tuned.environment} --budget {tuned.budget_steps} "
        f"--seed {tuned.seed}{options}: mean score over {scenarios} {checked.score:.4f}, before "
        f"{checked.score_of_start:.4f}, on {checked.episodes} fresh episodes from seed {checked.seed}"
    )


def _write_set(file: Path, tuned: TunedController, table: Mapping[str, Any]) -> None:
    """Replace the table of the set `tuned` on the environment of a search."""
    text = FileReader(SETTINGS_SIZE, GainsFileError).read_text(file)
    changed = replace_table(text, ("gains", TUNED, tuned.environment), table)
    expected = parse_toml(text)
    expected["gains"][TUNED][tuned.environment] = table
    if parse_toml(changed) != expected:
        raise DataFileError(file, "has another layout than [gains.<set>] tables with a line for each value")
    write_file(file, changed.encode())


def _rendered(spec: ControllerSpec, interface: ControlInterface) -> list[str]:
    return [name for name in spec.policy.rendered if name in interface.target_impedance]


def _usual(spec: ControllerSpec, common: Mapping[str, Any], name: str) -> Any:
    """The value that a setting has without an environment's own one; None for none."""
    return common[name] if name in common else getattr(spec.settings_class, name, None)


def _equal(value: Any, usual: Any) -> bool:
    if usual is None or isinstance(value, str) or isinstance(usual, str):
        return bool(value == usual)
    return np.shape(usual) in ((), (1,), np.shape(value)) and bool((np.asarray(value) == usual).all())


def _factor(value: Any, target: Any) -> Any:
    """What a target is multiplied by; 1 where it is 0."""
    wanted = np.asarray(target, dtype=np.float64)
    ratio = np.divide(value, wanted, out=np.ones(wanted.shape), where=wanted != 0.0)
    return _plain([float(f"{item:.{_DIGITS}g}") for item in ratio.tolist()])


def _plain(value: Any) -> Any:
    """A value as a gain set holds it: one number for several that are alike."""
    if isinstance(value, (list, tuple)):
        items = [float(item) for item in value]
        return items[0] if len(set(items)) == 1 else items
    return value
