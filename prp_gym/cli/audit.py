"""The command `prp-gym audit`."""

from typing import Annotated, Any

import typer

from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.cli.options import (
    Backend,
    Engine,
    Environments,
    Episodes,
    Json,
    ParallelWorkers,
    Plugins,
    Quiet,
    Resume,
    RunName,
    RunOutput,
    Scenarios,
    Seed,
    TableFormat,
)
from prp_gym.comparison.agents import find_agents
from prp_gym.comparison.audit import LEAST_CORRELATION, LEAST_POLICIES, STANDARD_ERRORS, audit_rewards
from prp_gym.comparison.audit_jobs import UNAWARE, list_audit_jobs
from prp_gym.comparison.audit_table import audit_table, unaware_table
from prp_gym.comparison.values import group_conditions
from prp_gym.console.terminal import Terminal
from prp_gym.evaluation.evaluate import check_protocol
from prp_gym.runs.choice import GainsChoice
from prp_gym.runs.job import Record, describe_jobs
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.run import Run
from prp_gym.runs.selection import Selection
from prp_gym.runs.workers import Workers
from prp_gym.tables.formats import TERMINAL
from prp_gym.tasks.setup import MUJOCO

_DEFAULT_SCENARIOS = ["realistic"]
_NOTE = (
    "rank correlation: Goodman and Kruskal's γ of the mean score with the smallness of each criterion, "
    f"over every two policies that it distinguishes by more than {STANDARD_ERRORS:g} standard errors of "
    f"their mean difference over the episodes, of at least {LEAST_POLICIES}; its 95 % interval is over "
    "episodes. Spearman's correlation stays below 1 where many policies are equally bad. An episode that "
    f"does not settle counts as the worst by every criterion. γ has to exceed {LEAST_CORRELATION:g}, and no "
    "policy of the best tenth by score may be in the worse half by a criterion. Energies are shown for "
    "information."
)


def audit_command(
    env: Environments = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    episodes: Episodes = 20,
    seed: Seed = 0,
    draws: Annotated[
        int, typer.Option(help="Random gains in all for the controllers intended for an environment.", min=1)
    ] = 30,
    engine: Engine = MUJOCO,
    output: RunOutput = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    resume: Resume = True,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Audit the reward: whether the score ranks policies as control engineers would.

    Controllers with their gain sets and with random gains, agents, floors and exploits of the reward are run;
    their scores are correlated with criteria that are not the reward's own signals. Fails where the score
    contradicts a criterion.
    """
    workers = Workers(jobs, backend)
    selected = Selection.of(env or [], scenario, [], GainsChoice())
    check_protocol(episodes, seed)
    terminal = Terminal.of(quiet, as_json, form)
    note_missing_compiler(terminal)
    with terminal.progress("trying out the controllers"):
        agents = find_agents(selected.environment_ids, [])
        listed = list_audit_jobs(selected, agents, episodes, seed, draws, engine)
    folder = ResultFolder.choose("audit", output, name, describe_jobs(listed), goes_on=resume)
    run = Run(folder.path, workers, selected.controllers, not resume, terminal)
    with run.hold(listed), folder.in_use():
        records = run.records(listed, "auditing")
        with terminal.progress("correlating scores with criteria"):
            audits = audit_rewards(group_conditions(map(_single, records)), seed)
        content = run.write(listed, records, {"audits": [item.to_plain() for item in audits]})
    tables = (audit_table(audits), unaware_table(audits, list(UNAWARE)))
    terminal.report(content, tables, [_NOTE], [f"results: {run.results}"])
    if not all(item.holds for item in audits):
        raise typer.Exit(1)


def _single(record: Record) -> dict[str, Any]:
    """A record whose policy is one agent, not the agents of all training seeds together."""
    if record["training_seed"] < 0:
        return record
    return {**record, "policy": f"{record['policy']} seed {record['training_seed']}"}
