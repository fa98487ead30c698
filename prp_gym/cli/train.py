"""The command `prp-gym train`."""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import gymnasium
import typer

from prp_gym.agents.training.recipes import SEEDS, Recipe, load_recipe
from prp_gym.agents.training.shipped import default_action_mode, read_groups
from prp_gym.artifacts import to_plain
from prp_gym.cli import completion
from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.cli.options import (
    Algorithm,
    Backend,
    DefaultActionMode,
    EngineOfRecipe,
    Json,
    Manifest,
    ParallelWorkers,
    Plugins,
    Quiet,
    RecipeFile,
    Resume,
    RunName,
    RunOutput,
    Settings,
    TableFormat,
)
from prp_gym.cli.training_progress import Result, results_table, train_seeds
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.extras import check
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.workers import Workers
from prp_gym.tables import ResultTable
from prp_gym.tables.formats import TERMINAL

if TYPE_CHECKING:
    from prp_gym.agents.training.train import TrainingJob

_EVALUATIONS, _EVALUATIONS_SHIPPED = 10, 20
_NOTE = "score: mean reward over held-out episodes, 1 is perfect."
_OF_ONE_GROUP = ("algo", "action_mode", "seeds", "first_seed")


def train_command(
    context: typer.Context,
    env_id: Annotated[
        str | None,
        typer.Argument(
            help="Id of a task or of its learning preset; none with --shipped.",
            autocompletion=completion.learning_ids,
        ),
    ] = None,
    shipped: Annotated[
        bool,
        typer.Option(
            "--shipped", help="In place of an id: all agents that come with the suite, each with its recipe."
        ),
    ] = False,
    manifest: Manifest = None,
    algo: Algorithm = "ppo",
    action_mode: DefaultActionMode = None,
    seeds: Annotated[int, typer.Option(help="Number of training seeds, with one agent each.")] = 1,
    first_seed: Annotated[int, typer.Option(help="First training seed.")] = 0,
    config: RecipeFile = None,
    settings: Settings = None,
    engine: EngineOfRecipe = None,
    output: RunOutput = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    eval_every: Annotated[
        int,
        typer.Option(help="Steps between evaluations; 0: a tenth of all steps, with --shipped a twentieth."),
    ] = 0,
    eval_episodes: Annotated[int, typer.Option(help="Held-out episodes of an evaluation.")] = 20,
    checkpoint_every: Annotated[
        int, typer.Option(help="Steps between checkpoints; 0: as between evaluations.")
    ] = 0,
    resume: Resume = True,
    tensorboard: Annotated[
        bool | None, typer.Option(help="Write TensorBoard's files.", show_default="unless --shipped")
    ] = None,
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Train agents with Stable-Baselines3 and keep the best policy of each.

    A seed whose run is finished is left as it is. A run that was interrupted goes on when the same command is
    given again: with new episodes, and all else as the last checkpoint has it.
    """
    workers = Workers(jobs, backend)
    _check_choice(context, env_id, shipped, manifest)
    _check_counts(seeds, first_seed, eval_every, eval_episodes, checkpoint_every)
    overrides = tuple(settings or ())
    if env_id is None:
        groups = [(group.recipe(config, overrides), range(group.seeds)) for group in read_groups(manifest)]
    else:
        mode = action_mode or default_action_mode(env_id, config)
        recipe = load_recipe(algo, env_id, mode, config, overrides)
        groups = [(recipe, range(first_seed, first_seed + seeds))]
    if engine is not None:
        groups = [(recipe.with_engine(engine), own_seeds) for recipe, own_seeds in groups]
    for recipe, _ in groups:
        _check_environment(recipe)
    logged = not shipped if tensorboard is None else tensorboard
    if logged:
        check("tensorboard")
    evaluations = _Evaluations(_EVALUATIONS_SHIPPED if shipped else _EVALUATIONS, eval_every, eval_episodes)
    terminal = Terminal.of(quiet, as_json, form)
    note_missing_compiler(terminal)
    folder = ResultFolder.choose("train", output, name, _describe(groups, evaluations), goes_on=resume)
    runs = _Runs(
        folder.path.resolve(),
        evaluations,
        checkpoint_every,
        "resume" if resume else "fresh",
        logged,
        _recipe_options(config, overrides, engine),
    )
    listed = [runs.jobs_of(recipe, own_seeds) for recipe, own_seeds in groups]
    every = [job for jobs in listed for job in jobs]
    with folder.in_use():
        results = train_seeds(every, workers, terminal)
    content = [{"folder": str(job.folder), **result} for job, result in zip(every, results, strict=True)]
    folders = dict.fromkeys(job.folder.parent for job in every)
    terminal.report(
        *({"runs": content}, list(_tables(listed, results)), [_NOTE]),
        lines=[f"runs: {folder}" for folder in folders],
    )


@dataclass(frozen=True)
class _Evaluations:
    """Schedule of the evaluations in training.

    Attributes:
        count: number of evaluations in the whole training.
        every: steps between evaluations, which replaces `count`; 0 to use `count`.
        episodes: number of episodes of each evaluation.
    """

    count: int
    every: int
    episodes: int

    def steps_between(self, recipe: Recipe) -> int:
        """Steps between two evaluations."""
        return self.every or max(1, recipe.n_timesteps // self.count)


@dataclass(frozen=True)
class _Runs:
    """Settings that the runs of all groups share.

    Attributes:
        output: folder that holds all runs.
        evaluations: evaluations during the training.
        checkpoint_every: steps between checkpoints; 0 for a checkpoint at every evaluation.
        existing: treatment of an unfinished run in the folder.
        tensorboard: whether to write TensorBoard's files.
        recipe_options: command options that changed the recipes.
    """

    output: Path
    evaluations: _Evaluations
    checkpoint_every: int
    existing: str
    tensorboard: bool
    recipe_options: tuple[str, ...]

    def jobs_of(self, recipe: Recipe, seeds: range) -> list["TrainingJob"]:
        """One job for each seed."""
        from prp_gym.agents.training.train import TrainingJob

        every = self.evaluations.steps_between(recipe)
        group = self.output / recipe.environment_id / recipe.name
        return [
            TrainingJob(
                *(recipe, seed, group / f"seed_{seed}", every, self.evaluations.episodes),
                *(self.checkpoint_every or every, self.existing, self.tensorboard),
                self._command(recipe, seed),
            )
            for seed in seeds
        ]

    def _command(self, recipe: Recipe, seed: int) -> str:
        """The command that trains this one agent again."""
        options = {
            "--algo": recipe.algorithm,
            "--action-mode": recipe.action_mode,
            "--first-seed": seed,
            "--eval-every": self.evaluations.steps_between(recipe),
            "--eval-episodes": self.evaluations.episodes,
        }
        given = (str(part) for option in options.items() for part in option)
        return shlex.join(["prp-gym", "train", recipe.environment_id, *given, *self.recipe_options])


def _recipe_options(config: Path | None, overrides: Sequence[str], engine: str | None) -> tuple[str, ...]:
    """The options that change recipes, as they are given."""
    chosen = (*(("--config", str(config)) if config else ()), *(("--engine", engine) if engine else ()))
    return (*chosen, *(part for text in overrides for part in ("--set", text)))


def _tables(groups: Sequence[Sequence["TrainingJob"]], results: Sequence[Result]) -> Iterator[ResultTable]:
    """A table for each recipe.

    Args:
        groups: training jobs of each recipe.
        results: results of all jobs in their order.
    """
    remaining = iter(results)
    for jobs in groups:
        yield results_table(jobs, list(islice(remaining, len(jobs))))


def _describe(groups: Sequence[tuple[Recipe, range]], evaluations: _Evaluations) -> list[Any]:
    """All that the results of a training depend on, as plain values."""
    return [[to_plain(recipe), list(seeds), to_plain(evaluations)] for recipe, seeds in groups]


def _check_choice(context: typer.Context, env_id: str | None, shipped: bool, manifest: Path | None) -> None:
    """Refuse options that do not go together."""
    if (env_id is None) != shipped:
        raise InvalidValueError("environment id and --shipped", (env_id, shipped), "exactly one of the two")
    if manifest is not None and not shipped:
        raise InvalidValueError("--manifest", str(manifest), "only with --shipped")
    for name in _OF_ONE_GROUP:
        source = context.get_parameter_source(name)
        if shipped and source is not None and source.name == "COMMANDLINE":
            option = f"--{name.replace('_', '-')}"
            raise InvalidValueError(option, context.params[name], "not with --shipped: the list says it")


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
