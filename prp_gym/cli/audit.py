"""The command `prp-gym audit`."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from prp_gym.cli.options import (
    Backend,
    Environments,
    FirstSeed,
    Fresh,
    Output,
    ParallelWorkers,
    Plugins,
    RunName,
    TableFormat,
)
from prp_gym.cli.shown import show_tables
from prp_gym.comparison.agents import find_agents
from prp_gym.comparison.audit import LEAST_CORRELATION, LEAST_POLICIES, audit_rewards
from prp_gym.comparison.audit_jobs import UNAWARE, list_audit_jobs
from prp_gym.comparison.audit_table import audit_table, unaware_table
from prp_gym.comparison.values import group_conditions
from prp_gym.evaluation.evaluate import check_protocol
from prp_gym.runs.choice import GainsChoice
from prp_gym.runs.job import Record, describe_jobs
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.run import Run
from prp_gym.runs.selection import Selection
from prp_gym.runs.workers import Workers
from prp_gym.tables.formats import TERMINAL


def audit_command(
    env: Environments = None,
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario; repeatable. Default: realistic.")
    ] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each policy on each environment.")] = 20,
    seed: FirstSeed = 0,
    draws: Annotated[
        int, typer.Option(help="Random gains in all for the controllers intended for an environment.", min=1)
    ] = 30,
    output: Output = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    fresh: Fresh = False,
    plugin: Plugins = None,
) -> None:
    """Audit the reward: whether the score ranks policies as control engineers would.

    Controllers with their gain sets and with random gains, agents, floors and exploits of the reward are run;
    their scores are correlated with criteria that are not the reward's own signals. Fails where the score
    contradicts a criterion.
    """
    workers = Workers(jobs, backend)
    selected = Selection.of(env or [], scenario or ["realistic"], [], GainsChoice())
    check_protocol(episodes, seed)
    listed = list_audit_jobs(selected, find_agents(selected.environment_ids, []), episodes, seed, draws)
    folder = ResultFolder.choose("audit", output, name, describe_jobs(listed), not fresh)
    run = Run(folder.path, workers, selected.controllers, fresh)
    with run.hold(listed), folder.in_use():
        records = run.records(listed, "auditing")
        audits = audit_rewards(group_conditions(map(_single, records)), seed)
        run.write(listed, records, {"audits": [item.to_plain() for item in audits]})
    show_tables([audit_table(audits), unaware_table(audits, list(UNAWARE))], _notes(run), form)
    if not all(item.holds for item in audits):
        raise typer.Exit(1)


def _single(record: Record) -> dict[str, Any]:
    """A record whose policy is one agent, not the agents of all training seeds together."""
    if record["training_seed"] < 0:
        return record
    return {**record, "policy": f"{record['policy']} seed {record['training_seed']}"}


def _notes(run: Run) -> Iterator[str]:
    """What explains the tables, and where the results are."""
    yield (
        "rank correlation: Goodman and Kruskal's γ of the mean score with the smallness of each criterion, "
        f"over every two policies that it distinguishes, of at least {LEAST_POLICIES}; its 95 % interval is "
        "over episodes. Spearman's correlation stays below 1 where many policies are equally bad. An episode "
        "that does not settle counts as the worst by every criterion. γ has to exceed "
        f"{LEAST_CORRELATION:g}, and no policy of the best tenth by score may be in the worse half by a "
        "criterion. Energies are shown for information."
    )
    yield f"results: {run.results}"
