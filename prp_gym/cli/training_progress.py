"""Training seeds of one recipe or of several as one list of work, with its progress and its results."""

import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from typing import TYPE_CHECKING, Any

from prp_gym.console.activity import Activity
from prp_gym.console.progress import Progress
from prp_gym.console.terminal import Terminal
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.runs.workers import Workers
from prp_gym.tables import Cell, ResultTable, TableColumn

if TYPE_CHECKING:
    from prp_gym.agents.training.train import TrainingJob

_WATCH_EVERY = 0.5  # s

Result = dict[str, Any]
"""What a run's `result.json` holds."""


def train_seeds(wanted: Sequence["TrainingJob"], workers: Workers, terminal: Terminal) -> list[Result]:
    """Train what is not finished yet, telling the progress on standard error.

    Args:
        wanted: training jobs, begun in this order.
        workers: processes that train.
        terminal: terminal to which the progress is written.

    Returns:
        the results, in the order of `wanted`.

    Raises:
        PRPError: a recipe that training refuses; unfinished runs that may not be resumed, or that another
            command is training, before any training begins.
    """
    from prp_gym.agents.training.train import is_ready, train

    missing = [index for index, job in enumerate(wanted) if not is_ready(job)]
    results = {index: train(job) for index, job in enumerate(wanted) if index not in missing}
    if results:
        terminal.note(f"{len(results)} of {len(wanted)} seeds are finished.")
    jobs = [wanted[index] for index in missing]
    with (
        _reserved(jobs),
        kept_if_interrupted(lambda: _kept(wanted)),
        terminal.progress("training", sum(job.recipe.n_timesteps for job in jobs), "steps") as progress,
        _watched(jobs, progress),
        closing(workers.run(train, jobs)) as trained,
    ):
        for number, result in trained:
            results[missing[number]] = result
            best = result["best"]
            outcome = f"best score {best['score']:.3f} at step {best['steps']}"
            minutes = f"{result['seconds'] / 60:.1f} minutes"
            terminal.note(f"{len(results)} of {len(wanted)}: {_name(jobs[number])}, {outcome}, {minutes}")
    return [results[index] for index in range(len(wanted))]


@contextmanager
def _reserved(jobs: Sequence["TrainingJob"]) -> Iterator[None]:
    """Lock the folders of all seeds, so that no other command begins one of them meanwhile."""
    from prp_gym.agents.training.run_folder import RunFolder

    with ExitStack() as stack:
        for job in jobs:
            stack.enter_context(RunFolder(job.folder).reserve())
        yield


def _kept(jobs: Sequence["TrainingJob"]) -> str:
    """What an interrupted command has kept; empty for nothing."""
    from prp_gym.agents.training.checkpoint import checkpoint_steps
    from prp_gym.agents.training.run_folder import RunFolder

    folders = {job.folder: RunFolder(job.folder) for job in jobs}
    finished = [job for job in jobs if folders[job.folder].is_finished]
    begun = [job for job in jobs if job not in finished and folders[job.folder].is_begun]
    kept = [f"{_name(job)} is kept at step {checkpoint_steps(job.folder)}" for job in begun]
    if finished:
        kept.insert(0, f"{len(finished)} of {len(jobs)} seeds are finished")
    return "; ".join([*kept, "the same command without --fresh goes on"]) if kept else ""


def _name(job: "TrainingJob") -> str:
    return f"{job.recipe.environment_id} {job.recipe.name} seed {job.seed}"


@contextmanager
def _watched(jobs: Sequence["TrainingJob"], progress: Progress) -> Iterator[None]:
    """Tell the steps of all seeds and of each in training, as their folders have them, while these train."""
    from prp_gym.agents.training.run_folder import RunFolder

    over = threading.Event()
    totals = [job.recipe.n_timesteps for job in jobs]
    folders = [RunFolder(job.folder) for job in jobs]

    def look() -> float:
        done = [min(folder.read_steps(), total) for folder, total in zip(folders, totals, strict=True)]
        progress.run(
            [
                Activity(_name(job), steps / total)
                for job, folder, steps, total in zip(jobs, folders, done, totals, strict=True)
                if steps > 0 and not folder.is_finished
            ]
        )
        return sum(done)

    def watch() -> None:
        while not over.wait(_WATCH_EVERY):
            progress.reach(look())

    progress.begin(look())
    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()


def results_table(jobs: Sequence["TrainingJob"], results: Sequence[Result]) -> ResultTable:
    """The results of one recipe, with one line for each training seed.

    Args:
        jobs: training jobs of the recipe, in the order of their seeds.
        results: results of the jobs, in the same order.
    """
    recipe = jobs[0].recipe
    title = f"{recipe.environment_id}, {recipe.algorithm}, action mode {recipe.action_mode}"
    columns = (
        *(TableColumn("seed"), TableColumn("best score"), TableColumn("step of the best score")),
        *(TableColumn("last score"), TableColumn("steps"), TableColumn("time", ("min",))),
    )
    return ResultTable.of(title, columns, [_row(job, own) for job, own in zip(jobs, results, strict=True)])


def _row(job: "TrainingJob", result: Result) -> tuple[Cell, ...]:
    best = result["best"]
    return (
        *(Cell.of(job.seed), Cell.number(best["score"]), Cell.of(best["steps"])),
        *(Cell.number(result["last_score"]), Cell.of(result["steps"])),
        Cell.number(result["seconds"] / 60.0, ".1f"),
    )
