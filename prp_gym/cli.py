"""The command `prp-gym`."""

import itertools
import shlex
import sys
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import typer
from rich.table import Table

from prp_gym.baselines import BASELINES, Baseline, list_baselines, make_baseline
from prp_gym.baselines.gains import gain_sets
from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError
from prp_gym.evaluation.evaluate import check_protocol, episodes_to_play, evaluate
from prp_gym.evaluation.results import describe_evaluation, describe_run, prepare_folder, write_json
from prp_gym.evaluation.table import Row, evaluation_table
from prp_gym.listing import list_command
from prp_gym.registration import list_envs
from prp_gym.reproduction.command import reproduce_command
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.terminal import TABLE_WIDTH, make_console, make_matrix, make_progress

_USAGE_ERROR = 2
_DEFAULT_SCENARIOS = ("report", "randomized")

Jobs = list[tuple[gymnasium.Env[Any, Any], list[Baseline[Any]]]]

app = typer.Typer(
    name="prp-gym",
    help="Gymnasium environments and classical baselines for the PRP arm.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"prp-gym {version('prp-gym')}")
        raise typer.Exit


@app.callback()
def common(
    _: Annotated[
        bool, typer.Option("--version", help="Show the version.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Gymnasium environments and classical baselines for the PRP arm."""


def _laws_with(gains: str) -> list[str]:
    """The laws that have a gain set."""
    laws = [name for name in BASELINES if gains in gain_sets(name)]
    if not laws:
        raise UnknownNameError("gain set", gains, {item for name in BASELINES for item in gain_sets(name)})
    return laws


def _check_names(kind: str, names: list[str], valid: list[str]) -> list[str]:
    for name in names:
        if name not in valid:
            raise UnknownNameError(kind, name, valid)
    return list(dict.fromkeys(names)) or valid


@app.command("evaluate")
def evaluate_command(
    env: Annotated[list[str] | None, typer.Option(help="Environment id; repeatable. Default: all.")] = None,
    baseline: Annotated[list[str] | None, typer.Option(help="Law; repeatable. Default: all.")] = None,
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario; repeatable. Default: report and randomized.")
    ] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each pair.")] = 20,
    seed: Annotated[int, typer.Option(help="Seed of the first episode.")] = 0,
    gains: Annotated[str, typer.Option(help="Gain set of the laws.")] = "tuned",
    control_frequency: Annotated[float, typer.Option(help="Actions a second [Hz].")] = 500.0,
    output: Annotated[Path, typer.Option(help="Folder for results.json.")] = Path("results"),
) -> None:
    """Evaluate classical baselines and print a table."""
    ids = _check_names("environment", env or [], list_envs())
    laws = _check_names("baseline", baseline or [], _laws_with(gains))
    scenarios = _check_names("scenario", scenario or list(_DEFAULT_SCENARIOS), list(SCENARIOS))
    check_protocol(episodes, seed)
    jobs = _jobs(itertools.product(ids, scenarios), laws, gains, control_frequency)
    _check_used(baseline or [], jobs)
    prepare_folder(output)
    records, tables = _play(jobs, episodes, seed, gains)
    target = output / "results.json"
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    write_json(target, {**describe_run(command), "evaluations": records})
    console = make_console(least=TABLE_WIDTH)  # where a terminal is narrower, lines wrap and no cell is cut
    for table in (*tables, *_scores(records)):
        console.print(table)
    console.print(
        "score: interquartile mean over episodes of return/duration, 1 is perfect; other figures are medians."
    )
    console.print(f"results: {target}", highlight=False)


def _play(jobs: Jobs, episodes: int, seed: int, gains: str) -> tuple[list[dict[str, Any]], list[Table]]:
    """Evaluate every job under a progress bar: what goes into the results, and a table a place."""
    records: list[dict[str, Any]] = []
    tables: list[Table] = []
    with make_progress() as progress:
        total = sum(episodes_to_play(made, episodes) * len(policies) for made, policies in jobs)
        bar = progress.add_task("evaluating", total=total)
        for made, policies in jobs:
            rows = []
            task = made.get_wrapper_attr("task")
            for policy in policies:
                name = policy.name
                progress.update(bar, description=f"{task.environment_id} {task.scenario.name} {name}")
                evaluation = evaluate(policy, made, episodes, seed, lambda: progress.advance(bar))
                rows.append(Row(name, evaluation))
                records.append(
                    describe_evaluation(evaluation, name, {"gains": gains, **vars(policy.settings)})
                )
            tables.append(evaluation_table(f"{task.environment_id}, scenario {task.scenario.name}", rows))
            made.close()
    return records, tables


def _scores(records: list[dict[str, Any]]) -> list[Table]:
    """The scores alone, a table a scenario; none where there is one environment only."""
    laws = list(dict.fromkeys(record["baseline"] for record in records))
    scores = {(r["scenario"], r["environment"], r["baseline"]): r["score"]["value"] for r in records}
    ids = list(dict.fromkeys(record["environment"] for record in records))
    if len(ids) == 1:
        return []
    tables = []
    for scenario in dict.fromkeys(record["scenario"] for record in records):
        rows = []
        for environment_id in ids:
            own = [scores.get((scenario, environment_id, law)) for law in laws]
            best = max(value for value in own if value is not None)
            cells = ["-" if v is None else f"{v:.3f}" + ("*" if v == best else " ") for v in own]
            rows.append((environment_id, cells))
        tables.append(make_matrix(f"score, scenario {scenario} (* best)", laws, rows))
    return tables


def _jobs(places: Iterable[tuple[str, str]], laws: list[str], gains: str, control_frequency: float) -> Jobs:
    """Environments with the laws that can run on them, all made before anything is played."""
    jobs = []
    for environment_id, scenario in places:
        made = gymnasium.make(environment_id, scenario=scenario, control_frequency=control_frequency)
        eligible = list_baselines(made.get_wrapper_attr("observation_layout"))
        policies = [make_baseline(name, made, gains) for name in laws if name in eligible]
        if policies:
            jobs.append((made, policies))
    return jobs


def _check_used(laws: list[str], jobs: Jobs) -> None:
    """Refuse a law that was asked for by name and runs on none of the environments."""
    used = {policy.name for _, policies in jobs for policy in policies}
    for law in laws:
        if law not in used:
            raise InvalidValueError(
                "baseline", law, f"a law that runs on the chosen environments: {sorted(used)}"
            )


app.command("list")(list_command)
app.command("reproduce")(reproduce_command)


def main() -> None:
    """Run the command; an error of this package ends with its message and exit code 2."""
    try:
        app()
    except PRPError as error:
        make_console(stderr=True).print(f"error: {error}", style="red", markup=False, highlight=False)
        sys.exit(_USAGE_ERROR)


if __name__ == "__main__":
    main()
