"""A recorded episode, and the protocol of policies."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.quantities import UNITS
from prp_gym.robot.arrays import Array
from prp_gym.tables import Cell, ResultTable
from prp_gym.tables.column import prose_column, text_column
from prp_gym.tables.data_frame import make_frame
from prp_gym.tasks.setup import MUJOCO

if TYPE_CHECKING:
    from prp_gym.figures.notebook_figure import NotebookFigure
    from prp_gym.tables.data_frame import DataFrame


@runtime_checkable
class Policy(Protocol):
    """Anything with Stable-Baselines3's `predict`: a baseline, a trained agent, a user's own class.

    A policy whose `predict` also takes several observations, (N, size), says so by the attribute
    `batched = True`; see `prp_gym.evaluation.policy_output.takes_batches`.
    """

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], Any]:
        """The action for an observation, and the policy's state for the next call."""


@dataclass(frozen=True, eq=False, repr=False)
class Rollout:
    """One episode of T control periods.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        seed: random seed with which the episode was reset.
        period: time between torques: the control period, or that of the inner controller of an action mode
            [s].
        duration: length that the episode has unless it diverges [s].
        fields: ground truth by field name (T + 1, size), the first row from the reset; the fields of the
            observation, without sensor errors, and those from which the task computes its reward.
        torque: commanded torques within the actuator limits (T, joints) [N m, N, N m].
        applied_torque: torques that acted on the joints (T, joints), with the scenario's actuation delay and
            noise [N m, N, N m].
        reward: sum of the reward terms in `info` (T), not changed by wrappers.
        info: numbers of `info` by name (T).
        diverged: whether the episode ended in a divergence.
        compute_time: time that the policy took for an action, for some or all actions [s]; the only part
            that is not reproducible. It includes the inner controller of an action mode, over all periods of
            the action.
        torque_limit: largest torques of the actuators (joints) [N m, N, N m].
        engine: name of the engine that simulated it.
    """

    environment_id: str
    scenario: str
    seed: int
    period: float
    duration: float
    fields: Mapping[str, Array]
    torque: Array
    applied_torque: Array
    reward: Array
    info: Mapping[str, Array]
    diverged: bool
    compute_time: Array
    torque_limit: Array
    engine: str = MUJOCO

    @property
    def planned_periods(self) -> int:
        """Number of control periods T of the episode unless it diverges."""
        return round(self.duration / self.period)

    @property
    def time(self) -> Array:
        """Times of the observations (T + 1) [s]."""
        return np.arange(len(self.reward) + 1, dtype=np.float64) * float(self.period)

    def __repr__(self) -> str:
        """The environment, the length and the score."""
        ended = ", diverged" if self.diverged else ""
        return (
            f"<Rollout of {len(self.reward)} periods ({self.time[-1]:g} s) of {self.environment_id}, scenario"
            f" {self.scenario}, seed {self.seed}: score {self.score:.3f}{ended}>"
        )

    @property
    def score(self) -> float:
        """Sum of the rewards over the planned number of periods, 1 is perfect [1]."""
        return float(self.reward.sum()) / self.planned_periods

    @property
    def table(self) -> ResultTable:
        """What the episode is, in a few lines."""
        facts = {
            "seed": f"{self.seed}",
            "length": f"{self.time[-1]:g} s of {self.duration:g} s, {1.0 / self.period:g} Hz",
            "score": f"{self.score:.3f}",
            "diverged": "yes" if self.diverged else "no",
            "recorded": ", ".join([*self.fields, "torque", "applied_torque", "reward"]),
        }
        title = f"episode of {condition_name(self.environment_id, self.scenario, self.engine)}"
        rows = [(name, Cell.of(text)) for name, text in facts.items()]
        return ResultTable.of(title, (text_column("fact"), prose_column("value")), rows)

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        return self.table._repr_html_()

    def to_frame(self) -> "DataFrame":
        """The episode as a data frame of pandas, a row for each of its T + 1 times.

        Returns:
            time [s], fields, torques, reward, and the numbers of `info` after `info_`. Those of a period
            stand at its beginning; at the last time they are NaN. Units stand in `attrs["units"]`.

        Raises:
            MissingPackageError: pandas is not installed.
        """
        periods = {"torque": self.torque, "applied_torque": self.applied_torque, "reward": self.reward}
        columns = {"time": self.time, **self.fields}
        periods |= {f"info_{name}": values for name, values in self.info.items()}
        columns |= {name: _with_last(values) for name, values in periods.items()}
        return make_frame(columns, UNITS)

    def plot(self, policy: str = "") -> "NotebookFigure":
        """The episode as a figure: motion, errors, torques, contact force and reward.

        Args:
            policy: name of the policy for the title; empty to leave it out.

        Returns:
            a figure of matplotlib with the panels that the task has.
        """
        from prp_gym.figures.episode_figure import draw_episode  # on use: the package stays light

        return draw_episode(self, policy)


def condition_name(environment_id: str, scenario: str, engine: str) -> str:
    """Environment and scenario for the title of a table, with the engine where it is not the reference."""
    return f"{environment_id}, scenario {scenario}{engine_suffix([engine])}"


def engine_suffix(engines: Iterable[str]) -> str:
    """The engines that are not the reference, for the end of a table's title."""
    return "".join(f", engine {engine}" for engine in sorted({*engines} - {MUJOCO}))


def _with_last(values: Array) -> Array:
    """Values of the periods (T, ...) with NaN for the time at the end (T + 1, ...)."""
    return np.concatenate([values, np.full_like(values[:1], np.nan, dtype=np.float64)])


def inner_time(loop: Any) -> float:
    """How long the inner controller of an action mode takes for one action of one environment [s].

    Args:
        loop: control loop of an environment; 0 of one whose actions are torques.
    """
    measure = getattr(loop, "inner_time", None)
    return 0.0 if measure is None else float(measure())


def check_environment(env: gymnasium.Env[Any, Any]) -> gymnasium.Env[Any, Any]:
    """The environment itself, without its wrappers.

    Raises:
        InvalidValueError: an environment of another suite.
    """
    inner = env.unwrapped
    if not hasattr(inner, "observation_layout"):
        raise InvalidValueError("env", env, "an environment of prp_gym")
    return inner
