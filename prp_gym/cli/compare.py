"""The command `prp-gym compare`."""

import itertools
import shlex
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import typer

from prp_gym.baselines import BASELINES
from prp_gym.cli.options import Backend, Controllers, Environments, FirstSeed, Fresh, ParallelWorkers
from prp_gym.cli.terminal import TABLE_WIDTH, make_console
from prp_gym.comparison.agents import AgentFile, find_agents
from prp_gym.comparison.jobs import (
    AgentJob,
    BudgetJob,
    ComparisonJob,
    ControllerJob,
    ZeroTorqueJob,
    find_tuned_controllers,
    list_varied,
)
from prp_gym.comparison.learning_plots import draw_learning
from prp_gym.comparison.outcome import Outcome
from prp_gym.comparison.plots import draw_compute, draw_profiles, draw_scores
from prp_gym.comparison.table import (
    aggregate_table,
    audit_table,
    condition_table,
    effort_table,
    pairwise_table,
    spread_table,
)
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import check_protocol, episodes_to_play
from prp_gym.evaluation.results import describe_run, prepare_folder, write_file, write_json
from prp_gym.registration import list_envs
from prp_gym.runs.job import list_jobs, make_environment
from prp_gym.runs.run import check_names, run_jobs
from prp_gym.runs.store import JobStore
from prp_gym.runs.workers import Workers
from prp_gym.tasks.scenario import SCENARIOS

_DEFAULT_SCENARIOS = ("randomized", "realistic")
_GAINS = "tuned"
_FREQUENCY = 500.0  # Hz, of the laws


def compare_command(
    env: Environments = None,
    baseline: Controllers = None,
    agent: Annotated[
        list[Path] | None,
        typer.Option(
            help="An agent beside those that come with the package: its file, or a folder with one of every "
            "training seed; repeatable."
        ),
    ] = None,
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario; repeatable. Default: randomized and realistic.")
    ] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each pair.")] = 50,
    seed: FirstSeed = 0,
    output: Annotated[Path, typer.Option(help="Folder for results.json and pictures.")] = Path("comparison"),
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    audit: Annotated[
        bool,
        typer.Option(
            "--audit",
            help="Play every law also with its other gain sets: the reward is checked over more policies, "
            "which appear nowhere else.",
        ),
    ] = False,
    fresh: Fresh = False,
) -> None:
    """Compare classical laws and learned agents on the same episodes.

    Laws have their tuned gains and set torques at 500 Hz; agents act in the mode and at the rate of their
    training. A run that was interrupted goes on where it stopped when the same command is given again.
    """
    workers = Workers(jobs, backend)
    ids = check_names("environment", env or [], list_envs())
    controllers = check_names("baseline", baseline or [], list(BASELINES))
    scenarios = check_names("scenario", scenario or list(_DEFAULT_SCENARIOS), list(SCENARIOS))
    check_protocol(episodes, seed)
    agents = find_agents(ids, agent or [])
    pairs = list_comparison_jobs(list(itertools.product(ids, scenarios)), controllers, agents, episodes, seed)
    _check_used(baseline or [], pairs)
    if audit:
        pairs += [item for pair in pairs if isinstance(pair, ControllerJob) for item in list_varied(pair)]
    finished = JobStore(output / "pairs")
    for folder in (output, output / "pairs"):
        prepare_folder(folder)
    if fresh:
        finished.remove(pairs)
    records = run_jobs(pairs, workers, finished, "comparing")
    outcome = Outcome.of(records, seed)
    _write(outcome, records, output)
    finished.remove(pairs)
    _show(outcome, output, busy=jobs != 1)


def _check_used(controllers: Sequence[str], pairs: Sequence[ComparisonJob]) -> None:
    """Refuse a law that was asked for by name and runs on none of the environments."""
    used = {pair.controller for pair in pairs if isinstance(pair, ControllerJob)}
    for controller in controllers:
        if controller not in used:
            allowed = f"a law that runs on the chosen environments: {sorted(used)}"
            raise InvalidValueError("baseline", controller, allowed)


def list_comparison_jobs(
    conditions: Sequence[tuple[str, str]],
    controllers: Sequence[str],
    agents: Sequence[AgentFile],
    episodes: int,
    seed: int,
) -> list[ComparisonJob]:
    """All that is to be played: at each place the laws, those tuned with a budget, the agents, the control.

    Args:
        conditions: environment ids and scenarios.
        controllers: baselines.
        agents: of all environments.
        episodes: of each pair, where they are not all the same.
        seed: of the first episode.
    """
    pairs: list[ComparisonJob] = []
    for environment_id, scenario in conditions:
        own = list_jobs([(environment_id, scenario)], controllers, _GAINS, _FREQUENCY, episodes, seed)
        pairs += [ControllerJob(**vars(pair)) for pair in own]
        with closing(make_environment(environment_id, scenario, _FREQUENCY)) as made:
            count = episodes_to_play(made, episodes)
        tuned = find_tuned_controllers(environment_id, [pair.controller for pair in own])
        pairs += [BudgetJob(controller, scenario, count, seed) for controller in tuned]
        pairs += [
            AgentJob(item, scenario, count, seed) for item in agents if item.environment_id == environment_id
        ]
        pairs.append(ZeroTorqueJob(environment_id, scenario, _FREQUENCY, count, seed))
    return pairs


def _write(outcome: Outcome, records: Sequence[Any], output: Path) -> None:
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    content = {**describe_run(command), "evaluations": records, **outcome.to_plain()}
    frames = {
        "profiles": draw_profiles(outcome.aggregates),
        "scores": draw_scores(outcome.conditions, outcome.seed),
        "compute": draw_compute(outcome.conditions),
    }
    if outcome.learned:
        frames["learning"] = draw_learning(outcome.conditions)
    for name, frame in frames.items():
        write_file(output / f"{name}.png", frame)
    write_json(output / "results.json", content)


def _show(outcome: Outcome, output: Path, busy: bool) -> None:
    """Print the tables, and what to know of them; `busy` if other work ran beside each pair."""
    console = make_console(least=TABLE_WIDTH)  # where a terminal is narrower, lines wrap and no cell is cut
    for place in outcome.conditions:
        console.print(condition_table(place, outcome.seed))
    notes = [
        "score: interquartile mean over episodes, and training seeds, of return/duration, 1 is perfect; its "
        "95 % interval is over both. Other figures are medians."
    ]
    if outcome.spread:
        console.print(spread_table(outcome.conditions))
    if outcome.pairwise_comparisons:
        console.print(pairwise_table(outcome.pairwise_comparisons))
        notes.append(
            "better: the policy whose score is higher by a paired difference whose interval does not contain "
            "0; disjoint intervals: whether those of the two scores do not overlap, which is stricter. The "
            "best policies are chosen on the same episodes."
        )
    if outcome.aggregates:
        console.print(aggregate_table(outcome.aggregates))
    if outcome.efforts:
        console.print(effort_table(outcome.efforts))
        notes.append(
            "learning effort: medians over training seeds, from the scores that training or tuning itself "
            "has measured, in the scenario named; violations: in the whole training."
        )
    if outcome.audits:
        console.print(audit_table(outcome.audits))
        notes.append(
            "rank correlation: over policies, between score and smallness of the physical error; its 95 % "
            "interval is over episodes. For policies that hardly differ it is left to chance: --audit adds "
            "more policies."
        )
    notes += [f"{name}: {reason}." for name, reason in _reasons(outcome)]
    if busy:
        notes.append(
            "compute time: per action, measured beside other work; for undisturbed times choose --jobs 1."
        )
    for note in notes:
        console.print(note, highlight=False)
    console.print(f"results: {output / 'results.json'}", highlight=False)


def _reasons(outcome: Outcome) -> list[tuple[str, str]]:
    """Why each physical error was chosen, once each."""
    return list(dict.fromkeys((audit.physical_error, audit.reason) for audit in outcome.audits))
