"""`DescribedController`: how a controller shows itself, as text, table, data frame and figure."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from prp_gym.baselines.base.settings import Settings
from prp_gym.evaluation.episode import record_episode
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column
from prp_gym.tables.data_frame import make_frame

if TYPE_CHECKING:
    from prp_gym.baselines.base.control_interface import ControlInterface
    from prp_gym.figures.notebook_figure import NotebookFigure
    from prp_gym.tables.data_frame import DataFrame

OwnSettings = TypeVar("OwnSettings", bound=Settings)

_COLUMNS = (text_column("setting"), TableColumn("value"), text_column("unit"))


@dataclass(frozen=True)
class Origin:
    """Where a controller's settings come from.

    Attributes:
        controller: name of the controller.
        gains: gain set, mapping or file of the settings, in words.
        overrides: names of the settings that were given in place of these.
    """

    controller: str
    gains: str = "given settings"
    overrides: tuple[str, ...] = ()

    def __str__(self) -> str:
        changed = f", {', '.join(self.overrides)} changed" if self.overrides else ""
        return f"{self.controller} with {self.gains}{changed}"


class DescribedController(Generic[OwnSettings]):
    """What all controllers show of themselves.

    Attributes:
        interface: what the controller may know of the environment.
        settings: settings of the controller, every vector at its full length.
        origin: where the settings come from.
    """

    interface: "ControlInterface"
    settings: OwnSettings
    origin: Origin

    def __repr__(self) -> str:
        """The controller's name, its gains and its environment."""
        frequency = f"{round(1.0 / self.interface.period, 6):g} Hz"
        return f"<{self.origin}, for {self.interface.environment_id} at {frequency}>"

    @property
    def table(self) -> ResultTable:
        """The settings, one line each, a vector with one number for each of its components."""
        numbers: dict[tuple[str, str], list[float]] = {}
        for name, _, value, unit in self._components():
            numbers.setdefault((name, unit), []).append(value)
        rows = [
            (name, Cell(" ".join(f"{value:.6g}" for value in own), tuple(own)), unit)
            for (name, unit), own in numbers.items()
        ]
        rows += [(name, Cell.of(str(getattr(self.settings, name))), "") for name in self.settings.choices]
        return ResultTable.of(f"{self.origin}, for {self.interface.environment_id}", _COLUMNS, rows)

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        return self.table._repr_html_()

    def to_frame(self) -> "DataFrame":
        """The settings as a data frame of pandas, a row for each component of each number.

        Returns:
            columns `setting`, `component` from 1, `value`, and `unit`.

        Raises:
            MissingPackageError: pandas is not installed.
        """
        rows = self._components()
        names = ("setting", "component", "value", "unit")
        return make_frame({name: [row[index] for row in rows] for index, name in enumerate(names)}, {})

    def plot(self, env: Any, seed: int = 0) -> "NotebookFigure":
        """Run one episode and draw it: motion, errors, torques, contact force and reward.

        Args:
            env: an environment for which the controller was made.
            seed: random seed of the episode.

        Raises:
            PRPError: an environment on which the controller cannot run.
        """
        policy: Any = self
        return record_episode(policy, env, seed).plot(str(self.origin))

    def _components(self) -> list[tuple[str, int, float, str]]:
        """Name, component, value and unit of every number among the settings."""
        settings = self.settings
        return [
            (name, index, float(value), unit)
            for name, unit in settings.units().items()
            for index, value in enumerate(np.atleast_1d(getattr(settings, name)), 1)
        ]
