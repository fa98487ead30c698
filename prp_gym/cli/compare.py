"""The command `prp-gym compare`."""

from pathlib import Path

from prp_gym.artifacts import write_file
from prp_gym.cli.options import (
    AgentPaths,
    Backend,
    ControllerNames,
    Environments,
    Episodes,
    Gains,
    Json,
    Output,
    ParallelWorkers,
    Plugins,
    Quiet,
    Resume,
    Scenarios,
    Seed,
    Settings,
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
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.run import Run
from prp_gym.runs.selection import Selection
from prp_gym.runs.workers import Workers

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
    output: Output = Path("comparison"),
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
    terminal = Terminal(quiet, as_json)
    with terminal.progress("trying out the controllers"):
        listed = list_comparison_jobs(selected, agents, episodes, seed)
    selected.check_used(listed)
    run = Run(output, workers, selected.controllers, not resume, terminal)
    with run.hold(listed):
        records = run.records(listed, "comparing")
        with terminal.progress("computing the statistics and drawing the figures"):
            outcome = Outcome.of(records, seed)
            _draw(outcome, output)
        content = run.write(listed, records, outcome.to_plain())
    terminal.document(content)
    _show(outcome, run)


def _draw(outcome: Outcome, folder: Path) -> None:
    """Write the figures."""
    figures = {
        "profiles": draw_profiles(outcome.aggregates),
        "scores": draw_scores(outcome.conditions, outcome.seed),
        "compute": draw_compute(outcome.conditions),
    }
    if outcome.learned:
        figures["learning"] = draw_learning(outcome.conditions)
    for name, figure in figures.items():
        write_file(folder / f"{name}.png", figure)


def _show(outcome: Outcome, run: Run) -> None:
    """Print the tables, with notes that explain them."""
    terminal = run.terminal
    for condition in outcome.conditions:
        terminal.show(condition_scores(condition, outcome.seed), condition_table(condition, outcome.seed))
    notes = [
        "score: mean over episodes, and training seeds, of the mean reward of a step, 1 is perfect; its 95 % "
        f"interval is over both. {SCORE_NOTE}"
    ]
    if outcome.spread:
        terminal.show(spread_table(outcome.conditions))
    if outcome.pairwise_comparisons:
        terminal.show(pairwise_table(outcome.pairwise_comparisons))
        notes.append(
            "better: the policy whose score is higher by a paired difference whose interval does not contain "
            "0; disjoint intervals: whether those of the two scores do not overlap, which is stricter. The "
            "best policies are chosen on the same episodes."
        )
    if outcome.aggregates:
        terminal.show(aggregate_table(outcome.aggregates))
    if outcome.efforts:
        terminal.show(effort_table(outcome.efforts))
        notes.append(
            "learning effort: medians over training seeds, from the mean scores that training or tuning "
            "itself has measured, in the scenario named; violations: in the whole training."
        )
    if run.busy:
        notes.append(
            "compute time: per action, measured beside other work; for undisturbed times choose --jobs 1."
        )
    terminal.explain(*notes)
    terminal.show(f"results: {run.results}")
