"""The command `prp-gym ship`."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer

from prp_gym.agents.policy.agent_card import Score
from prp_gym.agents.policy.agent_file import CARD, TENSORS, load_agent, save_agent
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.training.recipes import Recipe
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.shipped import read_groups
from prp_gym.artifacts import to_plain, write_file
from prp_gym.cli.options import (
    Backend,
    Episodes,
    Json,
    Manifest,
    Output,
    ParallelWorkers,
    Plugins,
    Quiet,
    RecipeFile,
    Seed,
    TableFormat,
)
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import check_protocol, evaluate
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.processes.leftovers import remove_leftovers
from prp_gym.runs.result_folder import latest_folder
from prp_gym.runs.workers import Workers
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column
from prp_gym.tables.formats import TERMINAL

_NAME_WIDTH = 44
_NOTE = "score: mean over episodes of the mean reward of a step with its 95 % interval, 1 is perfect."

SCENARIOS = ("randomized", "realistic")
"""Scenarios in which shipped agents are scored, besides that of their training."""


def ship_command(
    runs: Annotated[
        Path | None,
        typer.Option(help="Folder of the runs.", show_default="that of the latest prp-gym train"),
    ] = None,
    output: Output = Path("agents/trained"),
    manifest: Manifest = None,
    config: RecipeFile = None,
    episodes: Episodes = 100,
    seed: Seed = 0,
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    allow_missing: Annotated[
        bool, typer.Option("--allow-missing", help="Leave out what is not trained yet.")
    ] = False,
    form: TableFormat = TERMINAL,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Evaluate the agents that come with the suite, and put them where they are found by name.

    They are those that `prp-gym train --shipped` trains. Agents whose training differs from the recipe are
    refused; files that would not change are left as they are.
    """
    workers = Workers(jobs, backend)
    check_protocol(episodes, seed)
    recipes = [(group.recipe(config), group.seeds) for group in read_groups(manifest)]
    trained = latest_folder("train") if runs is None else runs
    wanted = [
        Candidate.of(recipe, number, trained, output, episodes, seed)
        for recipe, count in recipes
        for number in range(count)
    ]
    ready = [candidate for candidate in wanted if candidate.is_trained]
    missing = [str(candidate.run) for candidate in wanted if candidate not in ready]
    if missing and not (allow_missing and ready):
        raise InvalidValueError(
            "runs without a trained agent", missing, "none; prp-gym train --shipped trains them"
        )
    for candidate in ready:
        candidate.check()
    terminal = Terminal.of(quiet, as_json, form)
    with FolderLock(output).hold():
        changed = _ship(ready, workers, terminal)
        rows = [_row(candidate, candidate in changed) for candidate in ready]
        terminal.report({"agents": rows}, [_table(rows)], [_NOTE])
    _tell("not trained yet, left out", missing, terminal)
    _tell("not in the list, left as they are", _leftovers(output, wanted), terminal)


@dataclass(frozen=True)
class Candidate:
    """An agent that is to come with the suite.

    Attributes:
        run: folder of the training run.
        target: path of the shipped agent's files, without suffix.
        training_seed: seed of the training.
        settings: training settings that the run must have used.
        episodes: number of episodes of each evaluation.
        seed: seed of the first episode.
    """

    run: Path
    target: Path
    training_seed: int
    settings: dict[str, Any]
    episodes: int
    seed: int

    @classmethod
    def of(
        cls, recipe: Recipe, training_seed: int, runs: Path, output: Path, episodes: int, seed: int
    ) -> "Candidate":
        """The agent of a recipe and a training seed."""
        group = Path(recipe.environment_id) / recipe.name
        return cls(
            run=runs.resolve() / group / f"seed_{training_seed}",
            target=output.resolve() / group.with_name(f"{group.name}_seed_{training_seed}"),
            training_seed=training_seed,
            settings=to_plain(recipe.to_plain()),
            episodes=episodes,
            seed=seed,
        )

    @property
    def name(self) -> str:
        """Name of the agent: the folder of its group, and its file."""
        return f"{self.target.parent.name}/{self.target.name}"

    @property
    def is_trained(self) -> bool:
        """Whether its training is finished."""
        return RunFolder(self.run).is_finished

    def load(self) -> LearnedPolicy:
        """The agent as its training left it.

        Raises:
            AgentFileError: files that are missing or damaged.
        """
        return load_agent(RunFolder(self.run).agent)

    def check(self) -> None:
        """Refuse an agent whose training differs from the recipe.

        Raises:
            InvalidValueError: another recipe or seed.
            AgentFileError: files that are missing or damaged.
        """
        run = self.load().card.run
        there = {**to_plain(run.hyperparameters), "seed": run.seed}
        requested = {**self.settings, "seed": self.training_seed}
        for key in dict.fromkeys((*requested, *there)):
            if there.get(key) != requested.get(key):
                what = f"{key} of the agent in {str(self.run)!r}"
                raise InvalidValueError(what, there.get(key), f"{requested.get(key)!r}, as the recipe says")


def score_agent(candidate: Candidate) -> dict[str, Score]:
    """Scores of an agent by scenario.

    Args:
        candidate: agent with the number of its episodes.
    """
    policy = candidate.load()
    trained = str(policy.environment_keywords.get("scenario", EnvConfig.scenario))
    return {
        scenario: _score(policy, scenario, candidate.episodes, candidate.seed)
        for scenario in dict.fromkeys((*SCENARIOS, trained))
    }


def _score(policy: LearnedPolicy, scenario: str, episodes: int, seed: int) -> Score:
    with closing(policy.make_env(scenario=scenario)) as env:
        evaluation = evaluate(policy, env, episodes, seed)
    value, low, high = (float(number) for number in evaluation.score)
    return Score(value, low, high, len(evaluation.rollouts), seed)


def _ship(candidates: Sequence[Candidate], workers: Workers, terminal: Terminal) -> list[Candidate]:
    """Write the agents with their scores; those whose files are new or changed."""
    changed: list[Candidate] = []
    for folder in {candidate.target.parent for candidate in candidates}:
        remove_leftovers(folder)
    with (
        kept_if_interrupted(lambda: f"{len(changed)} agents are written; the same command writes the rest"),
        terminal.progress("evaluating", len(candidates), "agents") as progress,
        closing(workers.run(score_agent, candidates)) as scored,
    ):
        waiting = list(candidates)
        progress.run([Activity(item.name) for item in waiting[: workers.count]])
        for index, scores in scored:
            if _write(candidates[index], scores):
                changed.append(candidates[index])
            waiting.remove(candidates[index])
            progress.advance(1)
            progress.run([Activity(item.name) for item in waiting[: workers.count]])
    return changed


def _write(candidate: Candidate, scores: dict[str, Score]) -> bool:
    """Write an agent's files unless they are there as they would be written; whether it did."""
    policy = candidate.load()
    card = replace(policy.card, scores=scores)
    changed = False
    with TemporaryDirectory() as folder:
        made = save_agent(
            LearnedPolicy(card, policy.normalizer, policy.network), Path(folder) / candidate.target.name
        )
        for path in made:
            target = candidate.target.with_name(path.name)
            content = path.read_bytes()
            if not target.is_file() or target.read_bytes() != content:
                write_file(target, content)
                changed = True
    return changed


def _leftovers(output: Path, wanted: Sequence[Candidate]) -> list[str]:
    """Agents' files in the folder that belong to none of the list."""
    kept = {
        candidate.target.with_name(candidate.target.name + end)
        for candidate in wanted
        for end in (TENSORS, CARD)
    }
    found = (path for end in (TENSORS, CARD) for path in output.resolve().glob(f"*/*{end}"))
    return sorted(str(path) for path in found if path not in kept)


def _tell(what: str, names: Sequence[str], terminal: Terminal) -> None:
    """Print on standard error what should be checked before the agents are shipped."""
    if names:
        for line in (f"{what}:", *(f"  {name}" for name in names)):
            terminal.warn(line)


def _row(candidate: Candidate, written: bool) -> dict[str, Any]:
    """An agent with its scores by scenario, and whether its files were written."""
    return {"agent": candidate.name, "scores": load_agent(candidate.target).card.scores, "written": written}


def _table(rows: Sequence[dict[str, Any]]) -> ResultTable:
    """The agents' scores, one line for each agent."""
    columns = (
        text_column("agent", _NAME_WIDTH),
        *(TableColumn(f"score, {name}", parts=("mean", "low", "high")) for name in SCENARIOS),
        text_column("files"),
    )
    cells = (
        (
            row["agent"],
            *(_score_cell(row["scores"][name]) for name in SCENARIOS),
            "written" if row["written"] else "as before",
        )
        for row in rows
    )
    return ResultTable.of("agents", columns, cells)


def _score_cell(score: Score) -> Cell:
    text = f"{score.value:.3f} [{score.low:.3f}, {score.high:.3f}]"
    return Cell(text, (score.value, score.low, score.high))
