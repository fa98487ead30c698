"""`TrainingProgress`: evaluations, checkpoints, counters and the progress file during training."""

import time
from collections.abc import Callable
from dataclasses import asdict

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from prp_gym.agents.training.checkpoint import write_checkpoint
from prp_gym.agents.training.held_out import HeldOutEpisodes
from prp_gym.agents.training.model import Learner
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.training_state import BestPolicy, CurveRow, TrainingState
from prp_gym.artifacts import require_folder, write_json
from prp_gym.files.checksum import seal

_TELL_EVERY = 0.5  # s


class Milestones:
    """Regular numbers of steps at which something is done.

    Args:
        every: steps between two milestones.
        done: steps already trained; milestones up to there count as reached.
    """

    def __init__(self, every: int, done: int) -> None:
        self._every = every
        self._next = (done // every + 1) * every

    def reached(self, steps: int) -> bool:
        """Whether a milestone was reached since the last one that this method reported."""
        if steps < self._next:
            return False
        self._next = (steps // self._every + 1) * self._every
        return True


class TrainingProgress(BaseCallback):
    """Callback that evaluates the policy and writes checkpoints between two rollouts.

    At these times all updates are complete, so that a training resumed from a checkpoint has the state that
    this one had.

    Args:
        learner: model in training and its environments.
        state: progress of the run, which is updated.
        folder: folder of the run.
        held_out: episodes on which the policy is evaluated.
        evaluations: milestones of evaluations.
        checkpoints: milestones of checkpoints.
        report: function that is called with every evaluation; it may raise to end training.
    """

    def __init__(
        self,
        learner: Learner,
        state: TrainingState,
        folder: RunFolder,
        held_out: HeldOutEpisodes,
        evaluations: Milestones,
        checkpoints: Milestones,
        report: Callable[[CurveRow], None],
    ) -> None:
        super().__init__()
        self._learner, self._state, self._folder = learner, state, folder
        self._held_out, self._report = held_out, report
        self._evaluations, self._checkpoints = evaluations, checkpoints
        self._clock = time.perf_counter()
        self._told = 0.0

    def _on_step(self) -> bool:
        self._state.violations.add(self.locals["infos"], np.asarray(self.locals["dones"]))
        if time.perf_counter() - self._told > _TELL_EVERY:
            self._tell()
        return True

    def _on_rollout_start(self) -> None:
        steps = self.model.num_timesteps
        if self._evaluations.reached(steps):
            self._evaluate(steps)
        if self._checkpoints.reached(steps):
            self._keep()

    def _on_training_end(self) -> None:
        steps = self.model.num_timesteps
        if not self._state.curve or self._state.curve[-1].steps != steps:
            self._evaluate(steps)
        self._keep()
        self._tell()

    def _evaluate(self, steps: int) -> None:
        """Add a row to the learning curve, and store the policy if its score is the best so far."""
        start = time.perf_counter()
        normalizer = self._learner.normalizer
        score = self._held_out.score(self.model, normalizer)
        self._state.evaluation_seconds += time.perf_counter() - start
        self._count_seconds()
        row = CurveRow(steps, self._state.seconds, score, asdict(self._state.violations))
        self._state.curve.append(row)
        if not self._state.best or score > self._state.best[0].score:
            weights = {name: value.clone() for name, value in self.model.policy.state_dict().items()}
            self._state.best = [BestPolicy(steps, score, weights, normalizer)]
        self.logger.record("held_out/score", score)
        write_json(self._folder.curve, seal(self._state.plain_curve()))
        self._report(row)

    def _keep(self) -> None:
        self._count_seconds()
        write_checkpoint(self._folder.path, self._learner, self._state)

    def _count_seconds(self) -> None:
        now = time.perf_counter()
        self._state.seconds += now - self._clock
        self._clock = now

    def _tell(self) -> None:
        require_folder(self._folder.path)
        write_json(self._folder.progress, {"steps": self.model.num_timesteps})
        self._told = time.perf_counter()
