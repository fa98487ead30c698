"""The command `prp-gym train`."""

import shlex
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import gymnasium
import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.agents.recipes import SEEDS, Recipe, load_recipe
from prp_gym.errors import InvalidValueError
from prp_gym.parallel import Workers
from prp_gym.terminal import TABLE_WIDTH, make_console, make_progress

if TYPE_CHECKING:
    from prp_gym.agents.training import TrainingJob

_WATCH_EVERY = 0.5  # s
_EVALUATIONS = 10


def train_command(
    env_id: Annotated[str, typer.Argument(help="Environment id.")],
    algo: Annotated[str, typer.Option(help="ppo, sac, td3, tqc or recurrent_ppo.")] = "ppo",
    action_mode: Annotated[
        str | None, typer.Option(help="What actions mean. Default: what the recipe says.")
    ] = None,
    seeds: Annotated[int, typer.Option(help="Training seeds, an agent each.")] = 1,
    first_seed: Annotated[int, typer.Option(help="The first of them.")] = 0,
    config: Annotated[
        Path | None, typer.Option(help="Recipes in YAML, in place of those that come with the suite.")
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", help="key=value in place of the recipe's, as in YAML; repeatable."),
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder for the runs.")] = Path("runs"),
    eval_every: Annotated[int, typer.Option(help="Steps between evaluations; 0: a tenth of all steps.")] = 0,
    eval_episodes: Annotated[int, typer.Option(help="Held-out episodes of an evaluation.")] = 20,
    checkpoint_every: Annotated[
        int, typer.Option(help="Steps between checkpoints; 0: as between evaluations.")
    ] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with runs that were interrupted.")] = False,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Remove runs that are there, and start over.")
    ] = False,
    tensorboard: Annotated[bool, typer.Option(help="Write TensorBoard's files.")] = True,
    jobs: Annotated[
        int, typer.Option(help="Seeds at once; 1: in this process, 0: as many as there are cores.")
    ] = 0,
    backend: Annotated[
        str, typer.Option(help="loky: processes; ray: the cluster at RAY_ADDRESS, or a local one.")
    ] = "loky",
) -> None:
    """Train agents with Stable-Baselines3 and keep the best policy of each.

    A seed whose run is finished is left as it is. A run that was interrupted goes on with --resume: with new
    episodes, and all else as the last checkpoint has it.
    """
    workers = Workers(jobs, backend)
    recipe = load_recipe(algo, env_id, action_mode, config, set_ or [])
    _check_counts(seeds, first_seed, eval_every, eval_episodes, checkpoint_every)
    if resume and fresh:
        raise InvalidValueError("--resume together with --fresh", True, "one of them")
    _check_environment(recipe)
    from prp_gym.agents.training import TrainingJob, is_ready, train

    every = eval_every or max(1, recipe.n_timesteps // _EVALUATIONS)
    existing = "resume" if resume else "fresh" if fresh else "refuse"
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    group = (output / recipe.environment_id / recipe.name).resolve()
    wanted = [
        TrainingJob(
            *(recipe, seed, group / f"seed_{seed}", every, eval_episodes, checkpoint_every or every),
            *(existing, tensorboard, command),
        )
        for seed in range(first_seed, first_seed + seeds)
    ]
    ready = [job for job in wanted if is_ready(job)]  # refuses before anything is begun
    missing = [job for job in wanted if job not in ready]
    results = {job.seed: train(job) for job in ready}
    if ready:
        make_console(stderr=True).print(f"{len(ready)} of {len(wanted)} seeds are finished.", highlight=False)
    with _progress_of(missing), closing(workers.run(train, missing)) as trained:
        for index, result in trained:
            results[missing[index].seed] = result
    _show(recipe, results, group)


def _check_counts(
    seeds: int, first_seed: int, eval_every: int, eval_episodes: int, checkpoint_every: int
) -> None:
    least = {"seeds": (seeds, 1), "first_seed": (first_seed, 0), "eval_every": (eval_every, 0)}
    least |= {"eval_episodes": (eval_episodes, 1), "checkpoint_every": (checkpoint_every, 0)}
    for name, (value, smallest) in least.items():
        if value < smallest:
            raise InvalidValueError(name, value, f"a whole number, at least {smallest}")
    if first_seed + seeds > SEEDS:
        raise InvalidValueError("last seed", first_seed + seeds - 1, f"at most {SEEDS - 1}")


def _check_environment(recipe: Recipe) -> None:
    """Refuse keywords that the environment refuses, before a folder is made."""
    keywords: dict[str, Any] = dict(recipe.env_kwargs)
    gymnasium.make(recipe.environment_id, **keywords).close()


@contextmanager
def _progress_of(jobs: list["TrainingJob"]) -> Iterator[None]:
    """Bars of the seeds' steps, as their folders tell of them, while the training runs."""
    from prp_gym.agents.run_folder import RunFolder

    over = threading.Event()
    with make_progress() as progress:
        bars = {
            progress.add_task(f"seed {job.seed}", total=job.recipe.n_timesteps): RunFolder(job.folder)
            for job in jobs
        }

        def watch() -> None:
            while not over.wait(_WATCH_EVERY):
                for bar, folder in bars.items():
                    progress.update(bar, completed=folder.read_steps())

        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        try:
            yield
        finally:
            over.set()
            watcher.join()


def _show(recipe: Recipe, results: dict[int, dict[str, Any]], group: Path) -> None:
    """Print what came out, a line a seed."""
    title = f"{recipe.environment_id}, {recipe.algorithm}, action mode {recipe.action_mode}"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 2, 0, 0))
    for header in ("seed", "best score", "at step", "last score", "steps", "minutes"):
        table.add_column(header, justify="right")
    for seed, result in sorted(results.items()):
        best = result["best"]
        numbers = (f"{best['score']:.3f}", str(best["steps"]), f"{result['last_score']:.3f}")
        table.add_row(str(seed), *numbers, str(result["steps"]), f"{result['seconds'] / 60:.1f}")
    console = make_console(least=TABLE_WIDTH)
    console.print(table)
    console.print("score: mean of return/duration over held-out episodes, 1 is perfect.")
    console.print(f"runs: {group}", highlight=False)
