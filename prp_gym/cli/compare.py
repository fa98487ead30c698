"""The command `prp-gym compare`."""

from collections.abc import Iterator
from pathlib import Path

from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.cli.options import (
    AgentPaths,
    Backend,
    ControllerNames,
    Engine,
    Environments,
    Episodes,
    FigureFormat,
    Gains,
    Json,
    ParallelWorkers,
    Plugins,
    Quiet,
    Resume,
    RunName,
    RunOutput,
    Scenarios,
    Seed,
    Settings,
    TableFormat,
)
from prp_gym.comparison.agents import find_agents
from prp_gym.comparison.learning_plots import draw_learning
from prp_gym.comparison.listing import list_comparison_jobs
from prp_gym.comparison.outcome import Outcome
from prp_gym.comparison.plots import draw_compute, draw_profiles, draw_scores
from prp_gym.comparison.table import (
    aggregate_table,
    condition_scores,
    condition_table,
    effort_table,
    pairwise_table,
    spread_table,
)
from prp_gym.console.terminal import Terminal
from prp_gym.evaluation.evaluate import check_protocol
from prp_gym.evaluation.table import SCORE_NOTE
from prp_gym.figures.figure_file import write_figure
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.job import describe_jobs
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.run import Run
from prp_gym.runs.selection import Selection
from prp_gym.runs.workers import Workers
from prp_gym.tables import ResultTable
from prp_gym.tables.formats import TERMINAL
from prp_gym.tasks.setup import MUJOCO

_DEFAULT_SCENARIOS = ["randomized", "realistic"]


def compare_command(
    env: Environments = None,
    baseline: ControllerNames = None,
    agent: AgentPaths = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    episodes: Episodes = 50,
    seed: Seed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    engine: Engine = MUJOCO,
    output: RunOutput = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    figure_format: FigureFormat = "png",
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    resume: Resume = True,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Compare classical controllers and learned agents on the same episodes.

    Controllers set torques at 500 Hz; agents act in the action mode and at the control frequency of their
    training. A run that was interrupted goes on where it stopped when the same command is given again.
    """
    workers = Workers(jobs, backend)
    chosen = GainsChoice.read(gains, settings or ())
    selected = Selection.of(env or [], scenario, baseline or [], chosen)
    check_protocol(episodes, seed)
    agents = find_agents(selected.environment_ids, agent or [])
    terminal = Terminal.of(quiet, as_json, form)
    note_missing_compiler(terminal, selected.notes)
    with terminal.progress("trying out the controllers"):
        listed = list_comparison_jobs(selected, agents, episodes, seed, engine)
    selected.check_used(listed)
    folder = ResultFolder.choose("compare", output, name, describe_jobs(listed), goes_on=resume)
    run = Run(folder.path, workers, selected.controllers, not resume, terminal)
    with run.hold(listed), folder.in_use():
        records = run.records(listed, "comparing")
        with terminal.progress("computing the statistics and drawing the figures"):
            outcome = Outcome.of(records, seed)
            _draw(outcome, folder.path, figure_format)
        content = run.write(listed, records, outcome.to_plain())
    terminal.report(content, list(_tables(outcome)), _notes(outcome, run), [f"results: {run.results}"])


def _draw(outcome: Outcome, folder: Path, kind: str) -> None:
    """Write the figures."""
    figures = {
        "profiles": draw_profiles(outcome.aggregates),
        "scores": draw_scores(outcome.conditions, outcome.seed),
        "compute": draw_compute(outcome.conditions),
    }
    if outcome.learned:
        figures["learning"] = draw_learning(outcome.conditions)
    for name, figure in figures.items():
        write_figure(folder / f"{name}.{kind}", figure)


def _tables(outcome: Outcome) -> Iterator[ResultTable]:
    """The tables of a comparison, as far as it has what they show."""
    for condition in outcome.conditions:
        yield condition_scores(condition, outcome.seed)
        yield condition_table(condition, outcome.seed)
    if outcome.spread:
        yield spread_table(outcome.conditions)
    if outcome.pairwise_comparisons:
        yield pairwise_table(outcome.pairwise_comparisons)
    if outcome.aggregates:
        yield aggregate_table(outcome.aggregates)
    if outcome.efforts:
        yield effort_table(outcome.efforts)


def _notes(outcome: Outcome, run: Run) -> Iterator[str]:
    """What explains the tables."""
    yield (
        "score: mean over episodes, and training seeds, of the mean reward of a step, 1 is perfect; its 95 % "
        f"interval is over both. {SCORE_NOTE}"
    )
    if outcome.pairwise_comparisons:
        yield (
            "better: the policy whose score is higher by a paired difference whose interval does not contain "
            "0; disjoint intervals: whether those of the two scores do not overlap, which is stricter. The "
            "best policies are chosen on the same episodes."
        )
    if outcome.efforts:
        yield (
            "learning effort: medians over training seeds, from the mean scores that training or tuning "
            "itself has measured, in the scenario named; violations: in the whole training."
        )
    if run.busy:
        yield "compute time: per action, measured beside other work; for undisturbed times choose --jobs 1."
