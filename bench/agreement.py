"""`make bench-agreement`: the largest differences between the compiled engine and MuJoCo.

Both engines take the same random actions in every scenario and action mode of every task. Before each step
the compiled simulations and the memory of the mode are put where those of MuJoCo are. Scores of controllers
are compared over whole episodes, in which each engine goes its own way.
"""

import copy
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from itertools import product
from typing import Annotated, Any

import gymnasium
import numpy as np
import typer
from numpy.typing import NDArray

import prp_gym
from prp_gym.action_modes import list_action_modes
from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.envs.action_mode import TORQUE
from prp_gym.evaluation import evaluate
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.setup import COMPILED, MUJOCO

SMOOTH, COULOMB = 1e-9, 1e-5
"""Largest difference of a number after a step from the same state, relative to 1 + |number|: rounding without
Coulomb friction; with it, the tolerance at which MuJoCo's solver stops."""

SCORE = 1e-6
"""Largest difference of a score, for controllers with which small differences stay small."""

FREQUENCY = 500.0  # Hz, at which a step of every action mode is one period of its inner controller
COUNT = 6
_CHANCE, _LARGEST = 0.3, 1.3  # that a component of the action changes in a step, and its largest size
_TRIES = 4000
_SHARE, _AHEAD = 0.999, 0.0037  # of the bound of a velocity; and time to the bound of the position [s]


@dataclass(frozen=True)
class Condition:
    """What both engines simulate.

    Attributes:
        environment: environment id.
        scenario: scenario.
        mode: action mode.
    """

    environment: str
    scenario: str
    mode: str = TORQUE


@dataclass
class Agreement:
    """How the engines agree under a condition.

    Attributes:
        tolerance: largest difference that is allowed.
        differences: largest difference by quantity, relative to 1 + |number|.
        unequal: names of flags and counts that are not equal.
        events: numbers of terminations, truncations, stopped joints and contacts with MuJoCo.
    """

    tolerance: float
    differences: dict[str, float] = field(default_factory=dict)
    unequal: set[str] = field(default_factory=set)
    events: Counter[str] = field(default_factory=Counter)

    @property
    def largest(self) -> float:
        """The largest of all differences."""
        return max(self.differences.values())

    @property
    def holds(self) -> bool:
        """Whether flags and counts are equal, and all differences below the tolerance."""
        return not self.unequal and self.largest < self.tolerance

    def add(self, name: str, left: Array, right: Array) -> None:
        """Take account of numbers of MuJoCo and of the compiled engine."""
        size = float((np.abs(left - right) / (1.0 + np.abs(left))).max(initial=0.0))
        self.differences[name] = max(self.differences.get(name, 0.0), size)

    def add_equal(self, name: str, left: NDArray[Any], right: NDArray[Any]) -> None:
        """Take account of flags or counts."""
        if (left != right).any():
            self.unequal.add(name)


def _layout_of(environment_id: str) -> ObservationLayout:
    with closing(gymnasium.make(environment_id)) as env:
        layout: ObservationLayout = env.get_wrapper_attr("observation_layout")
        return layout


def modes_of(environment_id: str) -> list[str]:
    """All action modes of a task."""
    return list_action_modes(_layout_of(environment_id))


def conditions(environment_id: str) -> Iterator[Condition]:
    """A task in every scenario and action mode."""
    for mode in modes_of(environment_id):
        yield from (Condition(environment_id, scenario, mode) for scenario in SCENARIOS)


def compare(
    condition: Condition, steps: int, frequency: float = FREQUENCY, duration: float = 0.016
) -> Agreement:
    """Step both engines from the same states.

    Args:
        condition: what they simulate.
        steps: number of steps; an episode that has ended is followed by another.
        frequency: frequency of the actions [Hz].
        duration: length of an episode [s].
    """
    engines = Engines(condition, frequency, duration)
    rng, action = np.random.default_rng(1), np.zeros(engines.reference.action_space.shape)
    for _ in range(steps):
        drawn = rng.uniform(-_LARGEST, _LARGEST, action.shape)
        action = np.where(rng.random(action.shape) < _CHANCE, drawn, action)
        engines.step(action)
    return engines.agreement


class Engines:
    """Environments with MuJoCo, and the same with the compiled engine.

    They start as drawn (0), at the surface (1, 2), at the upper and the lower joint limits (3, 4), and about
    to leave the declared bounds (5).

    Args:
        condition: what they simulate.
        frequency: frequency of the actions [Hz].
        duration: length of an episode [s].
    """

    def __init__(self, condition: Condition, frequency: float, duration: float) -> None:
        self.reference, self.compiled = (
            _made(condition, engine, control_frequency=frequency, duration=duration)
            for engine in (MUJOCO, COMPILED)
        )
        friction = any(self.reference.task.scenario.coulomb_friction.high)
        self.agreement = Agreement(COULOMB if friction else SMOOTH)
        begun = [env.reset(seed=5)[0] for env in (self.reference, self.compiled)]
        self.agreement.add("observation", *begun)
        position, velocity = _starts(self.reference, np.random.default_rng(2))
        for env in (self.reference, self.compiled):
            env.physics.reset(np.arange(COUNT), position, velocity)
        self._running = np.ones(COUNT, dtype=np.bool_)

    def step(self, action: Array) -> None:
        """Step both from the state of MuJoCo; environments whose episodes have ended begin another one."""
        self._follow()
        one, other = self.reference.step(action), self.compiled.step(action)
        self._compare_ends(one, other)
        rows = ~one[2]  # the others go on to the end of the period with MuJoCo, and stay there compiled
        self.agreement.add("observation", one[0][rows], other[0][rows])
        self.agreement.add("reward", one[1], other[1])
        for name in (name for name in one[4] if not name.startswith("_")):
            if name.startswith("cost_"):
                self.agreement.add_equal(name, one[4][name][rows], other[4][name][rows])
            else:
                self.agreement.add(name, one[4][name][rows], other[4][name][rows])
        self._compare_attributes(rows)
        self._running = ~(one[2] | one[3])

    def _follow(self) -> None:
        """Put the compiled simulations, and the memory of the mode, where those of MuJoCo are."""
        rows, physics = np.flatnonzero(self._running), self.reference.physics
        if len(rows):
            positions, velocities = physics.joint_position[rows], physics.joint_velocity[rows]
            self.compiled.physics.reset(rows, positions, velocities)
        ours, theirs = self.compiled.loop, self.reference.loop
        if theirs.config.action_mode != TORQUE:
            ours._take_memory()
            ours._memory, ours._observation = copy.deepcopy(theirs.memory), theirs._observation.copy()

    def _compare_ends(self, one: tuple[Any, ...], other: tuple[Any, ...]) -> None:
        physics, events = self.reference.physics, self.agreement.events
        for name, index in (("terminated", 2), ("truncated", 3)):
            self.agreement.add_equal(name, one[index], other[index])
            events[name] += int(np.count_nonzero(one[index]))
        events["stopped"] += int(np.count_nonzero(physics.joints_at_stop))
        events["in contact"] += int(np.count_nonzero(physics.contact_force))

    def _compare_attributes(self, rows: NDArray[np.bool_]) -> None:
        """Ground truth and torques; environments that begin an episode in this step have had no torques."""
        self.agreement.add(
            "ground truth", self.reference.ground_truth[rows], self.compiled.ground_truth[rows]
        )
        stepped = rows & self._running
        for name in ("commanded_torque", "applied_torque"):
            ours, theirs = getattr(self.compiled, name), getattr(self.reference, name)
            self.agreement.add(name, theirs[stepped], ours[stepped])


def _made(condition: Condition, engine: str, **keywords: float) -> Any:
    """Environments with an engine; with MuJoCo, NumPy computes all but the physics."""
    given: dict[str, Any] = {
        "scenario": condition.scenario,
        "action_mode": condition.mode,
        "engine": engine,
        **keywords,
    }
    env: Any = gymnasium.make_vec(condition.environment, num_envs=COUNT, num_threads=1, **given)
    if engine == MUJOCO:
        env.unwrapped.loop._may_compile = False
    return env


def _starts(env: Any, rng: np.random.Generator) -> tuple[Array, Array]:
    """Positions and velocities (N, joints) from which events are near."""
    physics, task = env.physics, env.task
    position, velocity = physics.joint_position.copy(), physics.joint_velocity.copy()
    if hasattr(env.arm, "joint_limits"):
        low, high = env.arm.joint_limits
        velocity[3], velocity[4] = 0.1, -0.1
        if task.scenario.joint_stops:
            position[3], position[4] = high, low
        if physics.contact_force.size and physics.settings.surface:
            tries = rng.uniform(low, high, (_TRIES, len(low)))
            tips = env.arm.forward_kinematics(tries)[:, :3]
            for row in (1, 2):
                surface = physics.surface(row)
                distance = np.abs(tips @ np.ravel(surface.normal) - np.ravel(surface.offset))
                position[row], velocity[row] = tries[distance.argmin()], 0.3 * rng.normal(size=len(low))
    farthest, fastest = (item.high[0] for item in task.measured_fields[:2])
    position[5, 0], velocity[5, 0] = farthest - _AHEAD * fastest, _SHARE * fastest
    return position, velocity


def score_difference(environment_id: str, scenario: str, controller: str, **keywords: Any) -> float:
    """Largest difference of the scores of two episodes between the engines."""
    scores = []
    for engine in (MUJOCO, COMPILED):
        with closing(gymnasium.make(environment_id, scenario=scenario, engine=engine, **keywords)) as env:
            policy = make_baseline(controller, env)
            rollouts = evaluate(policy, env, episodes=2, seed=11).rollouts
            scores.append([float(rollout.reward.mean()) for rollout in rollouts])
    return float(np.abs(np.subtract(scores[0], scores[1])).max())


app = typer.Typer(add_completion=False)


@app.command()
def main(
    env: Annotated[list[str] | None, typer.Option(help="Environment id; repeatable. Default: all.")] = None,
    frequency: Annotated[float, typer.Option(help="Frequency of the actions [Hz].")] = FREQUENCY,
    duration: Annotated[float, typer.Option(help="Length of an episode of random actions [s].")] = 1.0,
) -> None:
    """Compare the engines on every task, in every scenario and action mode, and with every controller.

    The exit code is 1 where they differ.
    """
    failed = 0
    for environment in env or prp_gym.list_envs():
        for condition in conditions(environment):
            found = compare(condition, round(duration * frequency), frequency, duration)
            failed += _report(condition, found)
        for scenario, controller in product(SCENARIOS, list_baselines(_layout_of(environment))):
            size = score_difference(environment, scenario, controller)
            failed += size >= SCORE
            print(f"{environment} {scenario} {controller}: score differs by {size:.1e}", flush=True)
    raise typer.Exit(int(failed > 0))


def _report(condition: Condition, found: Agreement) -> bool:
    """Print how the engines agree; whether they differ."""
    worst = max(found.differences, key=lambda name: found.differences[name])
    said = "agrees" if found.holds else f"DIFFERS {sorted(found.unequal)}"
    what = f"{condition.environment} {condition.scenario} {condition.mode}"
    print(f"{what}: {found.largest:.1e} ({worst}), {said}; {dict(found.events)}", flush=True)
    return not found.holds


if __name__ == "__main__":
    app()
