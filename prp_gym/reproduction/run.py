"""`record_run`: simulates and records a run, on request with the state of its controller."""

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
from prp_gym.reproduction.experiment import ExperimentRun
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import NOMINAL
from prp_gym.tasks.registration import list_envs

SCENARIO = "report"


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A recorded run.

    Attributes:
        run: declaration of the run.
        rollout: the recorded episode, whose fields include the recorded states.
        settings: settings of the controller.
        gains_source: source of the gain set.
    """

    run: ExperimentRun
    rollout: Rollout
    settings: Mapping[str, Any]
    gains_source: str


class StateRecorder:
    """A policy that records the first arrays of another policy's state at every step.

    Args:
        policy: policy whose state is recorded.
        names: names of the arrays, in their order.
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
        """The action and the state of the other policy."""
        action, state = self._policy.predict(observation, state, episode_start, deterministic)
        if self._names:
            self._rows.append(tuple(np.array(part, dtype=np.float64).ravel() for part in state))
        return action, state

    def fields(self) -> dict[str, Array]:
        """The state after each step by name, (T + 1, size); NaN before the first step."""
        columns = zip(*self._rows, strict=True)
        stacked = {name: np.stack(column) for name, column in zip(self._names, columns, strict=False)}
        missing = [name for name in self._names if name not in stacked]
        if missing:
            raise InvalidValueError("recorded states", missing, f"at most {len(stacked)} of this controller")
        return {
            name: np.concatenate([np.full((1, values.shape[1]), np.nan), values])
            for name, values in stacked.items()
        }


def check_names(run: ExperimentRun) -> None:
    """Refuse a run whose environment, controller or gain set does not exist.

    Raises:
        UnknownNameError: one of them does not exist.
    """
    for kind, name, valid in (
        ("environment", run.environment, list_envs()),
        ("baseline", run.controller, list(BASELINES)),
        (f"gain set of controller {run.controller!r}", run.gains, gain_sets(run.controller)),
    ):
        if name not in valid:
            raise UnknownNameError(kind, name, valid)


def record_run(run: ExperimentRun) -> RecordedRun:
    """Simulate and record a run.

    Raises:
        PRPError: a name or value that the environment or the controller refuses.
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
    """Settings of a controller, with a model of the arm made from its link masses."""
    settings = dict(overrides)
    if "model_masses" in settings:
        settings["model"] = NOMINAL.with_masses(settings.pop("model_masses"))
    return settings
