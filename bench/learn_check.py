"""`make learn-check`: what stock algorithms learn on the learning presets, with their default numbers.

PPO and SAC of Stable-Baselines3 are trained on the learning preset of every task, with one environment and
seed 0, all other arguments at their defaults. The policies before and after, and zero torque, are evaluated
on the same fresh episodes. Results are stored after each training; docs/learning.md shows them all.
"""

import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

import prp_gym
from bench.machine import describe
from prp_gym.artifacts import write_json
from prp_gym.errors import PRPError, UnknownNameError
from prp_gym.evaluation.rollout import Policy
from prp_gym.files.file_reader import FileReader
from prp_gym.runs.workers import Workers
from prp_gym.tasks.presets import learning_id
from prp_gym.tasks.spec import TASKS

RESULTS = Path(__file__).with_name("learn_check.json")
STEPS = {"PPO": 100_000, "SAC": 20_000}
GOALS = {0.3: 3, 0.15: 7}
"""Numbers of tasks on which PPO shall end above the zero-torque baseline by a difference of scores."""

_EPISODES, _FIRST_SEED = 20, 1_000_000  # beyond the seeds that a training of these steps meets


@dataclass(frozen=True)
class Training:
    """One stock algorithm on the learning preset of one task.

    Attributes:
        task_id: Id of the task.
        algorithm: Name of a class of Stable-Baselines3.
        steps: Number of training steps.
    """

    task_id: str
    algorithm: str
    steps: int

    def run(self) -> dict[str, Any]:
        """Train, and evaluate before and after; all scores are means over the episodes."""
        import stable_baselines3
        import torch

        torch.set_num_threads(1)
        with closing(gymnasium.make(learning_id(self.task_id))) as env:
            model = getattr(stable_baselines3, self.algorithm)("MlpPolicy", env, seed=0, device="cpu")
            before, began = self._score(model), time.perf_counter()
            model.learn(self.steps)
            seconds = time.perf_counter() - began
        return {
            "task": self.task_id,
            "algorithm": self.algorithm,
            "steps": self.steps,
            "revision": TASKS[self.task_id].revision,
            "zero_torque": self._score(_Zero(int(np.prod(env.action_space.shape or ())))),
            "before": before,
            "after": self._score(model),
            "seconds": round(seconds, 1),
        }

    def _score(self, policy: Policy) -> float:
        with closing(gymnasium.make(learning_id(self.task_id))) as env:
            evaluation = prp_gym.evaluate(policy, env, episodes=_EPISODES, seed=_FIRST_SEED)
        return round(float(np.mean(evaluation.metrics["score"])), 4)


class _Zero:
    """The zero-torque baseline."""

    batched = True

    def __init__(self, size: int) -> None:
        self._size = size

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        """Zero actions, one for each observation."""
        return np.zeros((*np.shape(observation)[:-1], self._size), dtype=np.float32), state


def read_results() -> dict[str, Any]:
    """The stored results; without any, an empty list of runs."""
    stored: dict[str, Any] = FileReader().read_json(RESULTS) if RESULTS.exists() else {"runs": []}
    return stored


def goal_text(runs: Iterable[dict[str, Any]]) -> list[str]:
    """For each goal, how many tasks PPO has it on."""
    gains = [run["after"] - run["zero_torque"] for run in runs if run["algorithm"] == "PPO"]
    texts = []
    for least, count in GOALS.items():
        reached = f"{sum(gain >= least for gain in gains)} of {len(gains)}"
        texts.append(f"PPO ends at least {least:g} above zero torque on {reached} tasks (goal: {count})")
    return texts


def check(
    tasks: Annotated[list[str] | None, typer.Argument(help="Ids of tasks. Default: all.")] = None,
    algorithm: Annotated[
        list[str] | None, typer.Option(help="PPO or SAC; repeatable. Default: both.")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Parallel workers.")] = 2,
    resume: Annotated[
        bool, typer.Option("--resume", help="Keep the stored results of this revision.")
    ] = False,
) -> None:
    """Train stock algorithms on the learning presets, and store what they learn."""
    for kind, names, valid in (("environment", tasks, TASKS), ("algorithm", algorithm, STEPS)):
        for name in names or ():
            if name not in valid:
                raise UnknownNameError(kind, name, list(valid))
    chosen = [Training(task, name, STEPS[name]) for name in algorithm or STEPS for task in tasks or TASKS]
    stored = {_key(run): run for run in read_results()["runs"]}
    wanted = [
        one for one in chosen if not (resume and _is_current(one, stored.get((one.task_id, one.algorithm))))
    ]
    console = Console(width=110)
    for index, found in Workers(jobs).run(Training.run, wanted):
        stored[wanted[index].task_id, wanted[index].algorithm] = found
        write_json(RESULTS, {"about": describe("make learn-check"), "runs": _ordered(stored.values())})
        console.print(
            f"{found['algorithm']} {found['task']}: {found['zero_torque']:.3f} -> {found['after']:.3f}"
        )
    runs = read_results()["runs"]
    console.print(_table(runs))
    for text in goal_text(runs):
        console.print(text, highlight=False)


def _key(run: dict[str, Any]) -> tuple[str, str]:
    return run["task"], run["algorithm"]


def _is_current(training: Training, run: dict[str, Any] | None) -> bool:
    """Whether a stored result is one of this training and of the present revision of its task."""
    now = training.steps, TASKS[training.task_id].revision
    return run is not None and (run["steps"], run["revision"]) == now


def _ordered(runs: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Results in the order of the algorithms and tasks; those of tasks that no longer exist are left out."""
    by_key = {_key(run): run for run in runs}
    return [by_key[task, name] for name in STEPS for task in TASKS if (task, name) in by_key]


def _table(runs: Sequence[dict[str, Any]]) -> Table:
    table = Table(title="score of stock algorithms on the learning presets", title_justify="left")
    for header in ("algorithm", "task", "steps", "zero torque", "before", "after", "gain", "seconds"):
        table.add_column(header, justify="left" if header in ("algorithm", "task") else "right")
    for run in runs:
        scores = (run["zero_torque"], run["before"], run["after"], run["after"] - run["zero_torque"])
        cells = (f"{score:.3f}" for score in scores)
        table.add_row(run["algorithm"], run["task"], str(run["steps"]), *cells, f"{run['seconds']:.0f}")
    return table


if __name__ == "__main__":
    try:
        typer.run(check)
    except PRPError as error:
        sys.exit(f"error: {error}")
