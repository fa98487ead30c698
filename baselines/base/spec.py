"""`ControllerSpec`, the declaration of a controller, and the registry of controllers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Self

from prp_gym.baselines.base.policy import Baseline
from prp_gym.baselines.base.settings import Settings
from prp_gym.checks import instance
from prp_gym.errors import GainsFileError
from prp_gym.files.file_reader import SETTINGS_SIZE, FileReader
from prp_gym.registry import NOT_IN_THE_REPORT, Registry
from prp_gym.tasks.fields import ObservationLayout

TUNED = "tuned"
"""The gain set that is used unless another one is named."""

_TABLES = ("gains", "search")
_INTENDED = "intended"


@dataclass(frozen=True)
class ControllerData:
    """The numbers of a controller, in a TOML file that is read on first use.

    `[gains.<set>]` holds settings by name with their `source` and, where needed, the `minimum_frequency` [Hz]
    of control below which the set is refused; `[gains.<set>."<environment id>"]` holds the values that differ
    on one environment; there `target_factor.<setting>` multiplies the target impedance of the task, in a set
    that takes it. `[search.<parameter>]` is a parameter of tuning, a factor on the settings of the set
    `tuned`; `prp_gym.tuning.search_space` explains its rows. `intended` lists the ids of the environments for
    which the controller is meant, where its gains are searched. The suite's own sets are called

    - `report`: as the report prints them;
    - `figures`: as the report's author ran them, where its figures show other gains than its text;
    - `fast`: the report's stiff variant;
    - `tuned`: for 500 Hz, the nominal actuator limits and a plant that differs from the nominal arm;
    - `tuned_50hz`: the same for 50 Hz.

    Attributes:
        file: TOML file; None for a controller without gain sets and without a search space.
        target_impedance_sets: gain sets in which a task's target impedance replaces the set's own numbers.
    """

    file: Path | None = None
    target_impedance_sets: tuple[str, ...] = ()

    @classmethod
    def beside(cls, module: str, target_impedance_sets: tuple[str, ...] = ()) -> Self:
        """The file of the same name beside a module.

        Args:
            module: `__file__` of the module.
            target_impedance_sets: gain sets in which a task's target impedance replaces the numbers.
        """
        return cls(Path(module).with_suffix(".toml"), target_impedance_sets)

    @property
    def gains(self) -> Mapping[str, Mapping[str, Any]]:
        """The gain sets by name; none without a file.

        Raises:
            GainsFileError: a file that is missing, or not of this layout.
        """
        return self._table("gains")

    @property
    def search(self) -> Mapping[str, Mapping[str, Any]]:
        """The parameters of tuning by name; none without a file.

        Raises:
            GainsFileError: a file that is missing, or not of this layout.
        """
        return self._table("search")

    @property
    def intended(self) -> tuple[str, ...]:
        """Ids of the environments for which the controller is meant; none without a file.

        Raises:
            GainsFileError: a file that is missing, or not of this layout.
        """
        return () if self.file is None else tuple(_tables(self.file).get(_INTENDED, ()))

    def _table(self, name: str) -> Mapping[str, Mapping[str, Any]]:
        tables: Mapping[str, Any] = {} if self.file is None else _tables(self.file)
        table: Mapping[str, Mapping[str, Any]] = tables.get(name, {})
        return table


@dataclass(frozen=True)
class ControllerSpec:
    """The declaration of a controller; it stands in the controller's file.

    Attributes:
        name: registered name of the controller.
        summary: one line for lists.
        policy: class that computes the joint torques.
        data: gain sets and search space.
        command_inputs: named inputs of the controller that action modes may drive, such as `joint_offset`.
        chapter: chapter of the report, which orders lists.
        revision: revision of the controller's behaviour, stored in results.
    """

    name: str
    summary: str
    policy: type[Baseline[Any]]
    data: ControllerData = field(default_factory=ControllerData)
    command_inputs: tuple[str, ...] = ()
    chapter: float = NOT_IN_THE_REPORT
    revision: int = 1

    @property
    def settings_class(self) -> type[Settings]:
        """Class of the controller's settings."""
        return self.policy.settings_class

    @property
    def gain_sets(self) -> tuple[str, ...]:
        """Names of the gain sets; without a set `tuned` that name stands for the defaults of the settings."""
        names = tuple(self.data.gains)
        return names if TUNED in names else (TUNED, *names)

    def missing_fields(self, layout: ObservationLayout) -> list[str]:
        """Fields that the controller reads and that an environment's observations do not have."""
        return self.policy.missing_fields(layout)

    def make(self, env: Any) -> Baseline[Any]:
        """A policy for an environment with the gain set `tuned`; see `make_baseline`."""
        from prp_gym.baselines.base.make import make_baseline  # which knows this class

        return make_baseline(self, env)


CONTROLLERS: Registry[ControllerSpec] = Registry("baseline", "prp_gym.baselines")
"""The declared controllers by name."""


def register_controller(spec: ControllerSpec) -> ControllerSpec:
    """Declare a controller, so that it is listed, evaluated, compared and tuned with the others.

    Args:
        spec: declaration from this or another package. Without a set `tuned` its settings need defaults;
            without a search space each of its vector settings is tuned by a factor from 0.1 to 10.

    Returns:
        the same declaration.

    Raises:
        InvalidValueError: a name that another controller has, or that cannot be a file's name; a revision
            below 1.
    """
    return CONTROLLERS.register(instance("controller", spec, ControllerSpec))


def find_controller(controller: str | ControllerSpec) -> ControllerSpec:
    """The declaration of a controller, given as such or by its name.

    Raises:
        UnknownNameError: no controller has this name.
    """
    return controller if isinstance(controller, ControllerSpec) else CONTROLLERS.find(controller)


def read_toml(file: Path) -> dict[str, Any]:
    """What a TOML file of gains holds.

    Raises:
        GainsFileError: a file that cannot be read, or that is not TOML.
    """
    return FileReader(SETTINGS_SIZE, GainsFileError).read_toml(file)


@cache
def _tables(file: Path) -> Mapping[str, Any]:
    """The tables of a controller's data file, each with tables alone."""
    tables = read_toml(file)
    for name, table in tables.items():
        if name == _INTENDED:
            if not isinstance(table, list) or not all(isinstance(item, str) for item in table):
                raise GainsFileError(file, f"{name!r} must be a list of environment ids")
            continue
        if name not in _TABLES:
            raise GainsFileError(file, f"unknown table {name!r}; allowed: {', '.join(_TABLES)}")
        if not isinstance(table, dict) or not all(isinstance(row, dict) for row in table.values()):
            raise GainsFileError(file, f"{name!r} must hold tables, such as [{name}.<name>]")
    return tables
