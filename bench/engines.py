"""`make bench-engines`: the compiled engine compared with MuJoCo and with Reacher-v5.

Every program runs in a process of its own, in turn with the others, and is timed by the processor time that
the process takes, so that other programs of the machine disturb the ratios little.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import gymnasium
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.rounds import CONTACT, FREE, REACHER
from bench.single import bare_loop, random_actions
from prp_gym.baselines import CONTROLLERS, list_baselines, make_baseline
from prp_gym.evaluation import evaluate
from prp_gym.gradients.score_gradient import score_gradient
from prp_gym.tasks.setup import COMPILED, MUJOCO
from prp_gym.tuning.episodes import Episodes

FORCE = "PRP-Force-v0"
_SIZE = 1024
_ROUNDS, _SECONDS = 5, 1.0


@dataclass(frozen=True)
class Program:
    """What a process measures.

    Attributes:
        kind: `single`, `vector`, `bare`, `evaluate`, `held`, `gradient` or `scores`.
        environment: environment id.
        engine: engine of the environment; empty for one of another suite.
        scenario: scenario; empty for an environment of another suite.
    """

    kind: str
    environment: str
    engine: str = MUJOCO
    scenario: str = "randomized"


@dataclass(frozen=True)
class Comparison:
    """A ratio of rates.

    Attributes:
        what: what is compared, as the table tells it.
        program: program whose rate is the numerator.
        reference: program whose rate is the denominator.
        goal: least ratio that was aimed at.
    """

    what: str
    program: Program
    reference: Program
    goal: float


def comparisons() -> Iterator[Comparison]:
    """All comparisons, in the order of the table."""
    reacher = Program("single", REACHER, "", "")
    yield Comparison("step, N = 1, MuJoCo, against Reacher-v5", Program("single", FREE), reacher, 2.5)
    yield Comparison("step, N = 1, against Reacher-v5", Program("single", FREE, COMPILED), reacher, 8.0)
    for environment in (FREE, CONTACT, FORCE):
        one, other = (Program("vector", environment, engine) for engine in (COMPILED, MUJOCO))
        yield Comparison(f"step, N = {_SIZE}", one, other, 15.0)
        bare = Program("bare", environment)
        yield Comparison(f"step, N = {_SIZE}, against bare mj_step", one, bare, 10.0)
    for scenario in ("randomized", "realistic"):
        for environment in (FREE, CONTACT, FORCE):
            one, other = (Program("evaluate", environment, engine, scenario) for engine in (COMPILED, MUJOCO))
            yield Comparison("episodes of all traced controllers, with metrics", one, other, 15.0)
    for environment, goal in ((FREE, 1.0), (CONTACT, 4.0), (FORCE, 4.0)):
        one, other = (Program("held", environment, engine) for engine in (COMPILED, MUJOCO))
        yield Comparison("step of the action mode that ships, N = 8", one, other, goal)
    for environment in _CONTROLLERS:
        one, other = (Program(kind, environment, COMPILED) for kind in ("gradient", "scores"))
        yield Comparison("derivatives by all settings, against scores", one, other, 1.0 / 15.0)


def _keywords(program: Program) -> dict[str, Any]:
    return {"scenario": program.scenario, "engine": program.engine} if program.engine else {}


def _single(program: Program) -> Callable[[], float]:
    """Steps of one environment, with resets."""
    env = gymnasium.make(program.environment, **_keywords(program))
    actions = random_actions(1, (env.action_space.shape or ())[0])[:, 0]
    env.reset(seed=0)

    def chunk() -> float:
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return len(actions)

    return chunk


def _vector(program: Program, size: int = _SIZE, **more: Any) -> Callable[[], float]:
    """Steps of N environments."""
    env = gymnasium.make_vec(program.environment, num_envs=size, num_threads=1, **_keywords(program), **more)
    actions = list(random_actions(size, (env.single_action_space.shape or ())[0]))[:8]
    env.reset(seed=0)

    def chunk() -> float:
        for action in actions:
            env.step(action)
        return len(actions) * size

    return chunk


_HELD_MODE = {FREE: "joint_inverse_dynamics", CONTACT: "admittance", FORCE: "variable_force_position"}


def _held(program: Program) -> Callable[[], float]:
    """Steps of an action mode at 20 Hz, N = 8."""
    mode = _HELD_MODE[program.environment]
    return _vector(program, 8, action_mode=mode, control_frequency=20.0)


_CONTROLLERS = {FREE: "joint_inverse_dynamics", CONTACT: "impedance", FORCE: "force_inner_position"}
_SEEDS = range(64)  # of episodes of 500 periods


def _short(program: Program) -> tuple[Any, Any]:
    """An environment with episodes of 1 s, and a controller for it."""
    env = gymnasium.make(program.environment, duration=1.0, **_keywords(program))
    return env, make_baseline(_CONTROLLERS[program.environment], env)


def _gradient(program: Program) -> Callable[[], float]:
    """Episodes with the derivatives of their scores by all settings of a controller."""
    env, controller = _short(program)

    def chunk() -> float:
        return len(score_gradient(env, controller, _SEEDS).scores)

    return chunk


def _scores(program: Program) -> Callable[[], float]:
    """The same episodes without derivatives."""
    env, controller = _short(program)
    episodes = Episodes(env, _SEEDS)

    def chunk() -> float:
        return len(episodes.run(controller).scores)

    return chunk


def _bare(program: Program) -> Callable[[], float]:
    """Bare `mj_step` calls on the same models."""
    return bare_loop(gymnasium.make(program.environment, scenario=program.scenario))


def _evaluate(program: Program) -> Callable[[], float]:
    """Episodes of all controllers of a task that can be traced, with all metrics."""
    env = gymnasium.make(program.environment, **_keywords(program))
    layout = env.get_wrapper_attr("observation_layout")
    names = [name for name in list_baselines(layout) if CONTROLLERS.find(name).policy.compiled]
    policies = [make_baseline(name, env) for name in names]

    def chunk() -> float:
        for policy in policies:
            if not evaluate(policy, env, 20, seed=0).metrics:
                raise AssertionError
        return 20 * len(policies)

    return chunk


_KINDS = {
    "single": _single,
    "vector": _vector,
    "held": _held,
    "bare": _bare,
    "evaluate": _evaluate,
    "gradient": _gradient,
    "scores": _scores,
}


def measure(program: Program, seconds: float) -> float:
    """Rate of a program per second of processor time, in this process."""
    chunk = _KINDS[program.kind](program)
    if program.kind != "evaluate" or program.engine == COMPILED:
        chunk()
    done, start = 0.0, time.process_time()
    while (elapsed := time.process_time() - start) < seconds:
        done += chunk()
    return done / elapsed


def _measured(program: Program, seconds: float) -> float:
    """Rate of a program in a process of its own."""
    command = [sys.executable, "-m", "bench.engines", "--child", json.dumps(asdict(program))]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [*command, "--seconds", str(seconds)], check=True, capture_output=True, text=True, env=environment
    )
    return float(done.stdout.splitlines()[-1])


def table(rows: Sequence[dict[str, Any]]) -> Table:
    """The ratios of the rounds."""
    made = Table(title="rates per second of processor time", title_justify="left")
    for header in (
        "what",
        "environment",
        "scenario",
        "rate",
        "reference",
        "ratio",
        "range",
        "goal",
        "result",
    ):
        made.add_column(header)
    for row in rows:
        made.add_row(*(str(row[name]) for name in row))
    return made


def row_of(comparison: Comparison, rates: dict[Program, list[float]]) -> dict[str, Any]:
    """One row of the table."""
    one, other = np.array(rates[comparison.program]), np.array(rates[comparison.reference])
    ratio = one / other
    reached = float(np.median(ratio))
    return {
        "what": comparison.what,
        "environment": comparison.program.environment,
        "scenario": comparison.program.scenario,
        "rate": f"{np.median(one):,.0f}",
        "reference": f"{np.median(other):,.0f}",
        "ratio": _short_number(reached),
        "range": f"{_short_number(ratio.min())} to {_short_number(ratio.max())}",
        "goal": f"at least {comparison.goal:.2g}",
        "result": "met" if reached >= comparison.goal else "missed",
    }


def _short_number(ratio: float) -> str:
    return f"{ratio:.1f}" if ratio >= 1.0 else f"{ratio:.2f}"


app = typer.Typer(add_completion=False)


@app.command()
def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds, in which every program runs once.")] = _ROUNDS,
    seconds: Annotated[float, typer.Option(help="Processor time of a program in a round [s].")] = _SECONDS,
    only: Annotated[str, typer.Option(help="Kind of programs to measure; empty for all.")] = "",
    child: Annotated[str, typer.Option(hidden=True)] = "",
) -> None:
    """Compare the engines, and print a table."""
    if child:
        print(measure(Program(**json.loads(child)), seconds))
        return
    chosen = [one for one in comparisons() if only in ("", one.program.kind)]
    programs = dict.fromkeys(side for one in chosen for side in (one.program, one.reference))
    rates: dict[Program, list[float]] = {program: [] for program in programs}
    for _ in range(rounds):
        for program in programs:
            rates[program].append(_measured(program, seconds))
    rows = [row_of(one, rates) for one in chosen]
    Console(width=170).print(table(rows))


if __name__ == "__main__":
    app()
