"""`train`: training of one agent, from a recipe to a finished run folder."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.sb3.packages import require
from prp_gym.agents.training.checkpoint import (
    find_checkpoint,
    read_resumes,
    remove_checkpoints,
    remove_incomplete,
    restore_checkpoint,
)
from prp_gym.agents.training.finish import finish_run
from prp_gym.agents.training.held_out import HeldOutEpisodes
from prp_gym.agents.training.model import Learner, make_learner
from prp_gym.agents.training.progress import Milestones, TrainingProgress
from prp_gym.agents.training.recipes import FIRST_HELD_OUT_SEED, Recipe
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.training_state import CurveRow, TrainingState
from prp_gym.artifacts import write_json
from prp_gym.errors import OutputError, RunFolderError
from prp_gym.files.checksum import seal

_TO_GO_ON = "To resume it, give --resume; to start over, --fresh"

ON_EXISTING = ("refuse", "resume", "fresh")


@dataclass(frozen=True)
class TrainingJob:
    """One training seed of a recipe.

    Attributes:
        recipe: recipe of the training.
        seed: training seed.
        folder: path of the run's folder.
        eval_every: number of steps between two evaluations.
        eval_episodes: number of held-out episodes in an evaluation.
        checkpoint_every: number of steps between two checkpoints; 0 for the same as `eval_every`.
        existing: treatment of an unfinished run in the folder, one of `ON_EXISTING`.
        tensorboard: whether to write TensorBoard's files.
        command: command line that started the training, for the record.
    """

    recipe: Recipe
    seed: int
    folder: Path
    eval_every: int
    eval_episodes: int = 20
    checkpoint_every: int = 0
    existing: str = "refuse"
    tensorboard: bool = True
    command: str = ""

    @property
    def settings(self) -> dict[str, Any]:
        """Settings other than the recipe that determine the result."""
        return {
            "seed": self.seed,
            "eval_every": self.eval_every,
            "eval_episodes": self.eval_episodes,
            "first_held_out_seed": FIRST_HELD_OUT_SEED,
        }


def _ignore(_: CurveRow) -> None:
    """Discard an evaluation."""


def is_ready(job: TrainingJob) -> bool:
    """Whether the run of a job is already finished.

    Args:
        job: training job.

    Raises:
        RunFolderError: an unfinished run that may not be resumed, or a run with other settings.
    """
    folder = RunFolder(job.folder)
    if job.existing == "fresh" or not folder.is_begun:
        return False
    folder.check_same(job.recipe, job.settings)
    if not folder.is_finished and job.existing != "resume":
        raise RunFolderError(job.folder, "it holds an unfinished run", _TO_GO_ON)
    return folder.is_finished


def train(job: TrainingJob, report: Callable[[CurveRow], None] = _ignore) -> dict[str, Any]:
    """Train an agent, unless its run is finished.

    A run that is resumed after an interruption starts new episodes with seeds of their own; everything else
    is as in the last checkpoint.

    Args:
        job: training job.
        report: function that is called with every evaluation; it may raise to end training.

    Returns:
        the content of the run's `result.json`.

    Raises:
        RunFolderError: a run in the folder that may not be resumed, or that has other settings.
        CheckpointError: a damaged checkpoint.
        FolderInUseError: another process trains in the folder.
        OutputError: the folder was removed or cannot be written to, as when the disk is full.
        PRPError: keywords that the environment refuses.
    """
    folder = RunFolder(job.folder)
    if is_ready(job):
        return folder.read_result()
    try:
        with folder.hold():
            return _train(job, folder, report)
    except OSError as error:  # of TensorBoard's writer, for instance
        raise OutputError(job.folder, error) from error


def _train(job: TrainingJob, folder: RunFolder, report: Callable[[CurveRow], None]) -> dict[str, Any]:
    """Train in a folder that this process has locked."""
    if is_ready(job):  # finished by another process just before
        return folder.read_result()
    if job.existing == "fresh":
        folder.remove()
    if not folder.is_begun:
        _begin(job, folder)
    remove_incomplete(job.folder)
    found = find_checkpoint(job.folder)
    resumes = read_resumes(found[0]) + 1 if found else 0
    with closing(make_learner(job.recipe, job.seed, resumes)) as learner:
        state = TrainingState()
        if found:
            state = restore_checkpoint(found[0], learner)
            state.resumes = resumes
        _learn(job, folder, learner, state, report)
        result = finish_run(job.recipe, job.seed, folder, learner, state)
    remove_checkpoints(job.folder)
    return result


def _begin(job: TrainingJob, folder: RunFolder) -> None:
    facts = {
        "command": job.command,
        "environment": job.recipe.environment_id,
        "algorithm": job.recipe.algorithm,
        "seed": job.seed,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    folder.begin(job.recipe, job.settings, facts)


def _learn(
    job: TrainingJob,
    folder: RunFolder,
    learner: Learner,
    state: TrainingState,
    report: Callable[[CurveRow], None],
) -> None:
    """Train until the number of steps of the recipe is reached."""
    model = learner.model
    model.set_logger(_make_logger(job, folder))
    done = model.num_timesteps
    write_json(folder.curve, seal(state.plain_curve()))  # without the rows after the last checkpoint
    evaluations = Milestones(job.eval_every, done)
    checkpoints = Milestones(job.checkpoint_every or job.eval_every, done)
    with closing(HeldOutEpisodes(job.recipe, job.eval_episodes)) as held_out:
        progress = TrainingProgress(learner, state, folder, held_out, evaluations, checkpoints, report)
        try:
            model.learn(
                job.recipe.n_timesteps - done,
                progress,
                reset_num_timesteps=False,
                log_interval=_log_interval(job),
            )
        finally:
            model.logger.close()


def _log_interval(job: TrainingJob) -> int:
    """Rollouts between two entries of the log; episodes, for an algorithm with a replay buffer."""
    return job.recipe.n_envs if ALGORITHMS.find(job.recipe.algorithm).scope.replay_buffer else 1


def _make_logger(job: TrainingJob, folder: RunFolder) -> Logger:
    if not job.tensorboard:
        return Logger(None, [])
    require("tensorboard")
    return Logger(str(folder.tensorboard), [TensorBoardOutputFormat(str(folder.tensorboard))])
