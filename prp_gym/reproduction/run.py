"""Playing a run and recording it, with what the policy keeps in its state where that is asked for."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines import BASELINES, make_baseline
from prp_gym.baselines.base.gains import gain_sets, load_gains
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation.episode import record_episode
from prp_gym.evaluation.rollout import Policy, Rollout
from prp_gym.reproduction.experiment import Run
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import NOMINAL
from prp_gym.tasks.registration import list_envs

SCENARIO = "report"


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A recorded run.

    Attributes:
        run: what was played.
        rollout: the record; its fields hold the recorded states too.
        settings: of the law.
        gains_source: where the gain set is from.
    """

    run: Run
    rollout: Rollout
    settings: Mapping[str, Any]
    gains_source: str


class StateRecorder:
    """A policy that keeps the first arrays of another policy's state, step by step.

    Args:
        policy: the other one.
        names: of the arrays, in order.
    """

    def __init__(self, policy: Policy, names: tuple[str, ...]) -> None:
        self._policy = policy
        self._names = names
        self._rows: list[tuple[Array, ...]] = []

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], Any]:
        """The other policy's answer."""
        action, state = self._policy.predict(observation, state, episode_start, deterministic)
        if self._names:
            self._rows.append(tuple(np.array(part, dtype=np.float64).ravel() for part in state))
        return action, state

    def fields(self) -> dict[str, Array]:
        """By name (T + 1, size): the state after each step; NaN before the first."""
        columns = zip(*self._rows, strict=True)
        stacked = {name: np.stack(column) for name, column in zip(self._names, columns, strict=False)}
        missing = [name for name in self._names if name not in stacked]
        if missing:
            raise InvalidValueError("recorded states", missing, f"at most {len(stacked)} of this law")
        return {
            name: np.concatenate([np.full((1, values.shape[1]), np.nan), values])
            for name, values in stacked.items()
        }


def check_names(run: Run) -> None:
    """Refuse a run whose environment, law or gain set does not exist.

    Raises:
        UnknownNameError: names what is valid.
    """
    for kind, name, valid in (
        ("environment", run.environment, list_envs()),
        ("baseline", run.controller, list(BASELINES)),
        (f"gain set of law {run.controller!r}", run.gains, gain_sets(run.controller)),
    ):
        if name not in valid:
            raise UnknownNameError(kind, name, valid)


def play(run: Run) -> RecordedRun:
    """Play a run.

    Raises:
        PRPError: a name or value that environment or law refuses.
    """
    check_names(run)
    keywords = dict(run.keywords) | ({"torque_limit": None} if run.unlimited_torque else {})
    env = gymnasium.make(
        run.environment,
        scenario=SCENARIO,
        control_frequency=run.control_frequency,
        duration=run.duration,
        **keywords,
    )
    with closing(env):
        policy = make_baseline(run.controller, env, run.gains, **_settings(run.overrides))
        recorder = StateRecorder(policy, run.states)
        rollout = record_episode(recorder, env, run.seed, dict(run.options))
    source = str(load_gains(run.controller, run.gains, run.environment)["source"])
    with_states = replace(rollout, fields={**rollout.fields, **recorder.fields()})
    return RecordedRun(run, with_states, vars(policy.settings), source)


def _settings(overrides: Mapping[str, Any]) -> dict[str, Any]:
    """A law's settings, the model of other masses in place of the masses."""
    settings = dict(overrides)
    if "model_masses" in settings:
        settings["model"] = NOMINAL.with_masses(settings.pop("model_masses"))
    return settings
