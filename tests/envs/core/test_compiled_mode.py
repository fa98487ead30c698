"""Steps of action modes in compiled code: the bits of the loop that NumPy goes through period by period."""

import copy
import pickle
from collections.abc import Callable, Iterator
from itertools import cycle
from typing import Any

import numpy as np
import pytest

from prp_gym.action_modes import ACTION_MODES, register_action_mode
from prp_gym.baselines import CONTROLLERS
from prp_gym.envs import PRPVectorEnv
from prp_gym.envs.action_mode import ActionMode, ActionModeSpec, ModeSetup
from prp_gym.envs.core.step import Step
from prp_gym.errors import EpisodeError, NonFiniteError
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS
from tests.support.compiled_modes import (
    SHOWN,
    assert_same_steps,
    compiled,
    has_code,
    in_numpy,
    stepped_in_code,
)
from tests.support.compiler import needs_compiler
from tests.support.mode_episodes import COVERING, controller_of, random_actions
from tests.support.synthetic_mode import NEVER, WILD, LateEntry, LateMode, violent_in
from tests.support.vector_episodes import MODES, assert_same, together

pytestmark = needs_compiler

FORCE = "PRP-ForcePosition-v0"
SHORT: dict[str, Any] = {"control_frequency": 50, "duration": 0.12, "scenario": "realistic"}
STATEFUL = "variable_force_position"
BY_TURNS = [
    (*each, scenario, count)
    for each, scenario, count in zip(COVERING, cycle(SCENARIOS), cycle((1, 3, 3)), strict=False)
]
COPIES: dict[str, Callable[[PRPVectorEnv], PRPVectorEnv]] = {
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize(("environment_id", "mode", "scenario", "count"), BY_TURNS)
def test_steps_are_those_that_numpy_computes(
    environment_id: str, mode: str, scenario: str, count: int
) -> None:
    """Whole episodes, with resets of some environments and with divergences."""
    ours, theirs = (
        make(environment_id, mode, count, **{**SHORT, "scenario": scenario}) for make in (compiled, in_numpy)
    )
    assert assert_same_steps(ours, theirs, 9) >= 1
    assert has_code(ours) is CONTROLLERS.find(controller_of(mode)).policy.compiled
    assert not has_code(theirs)


def test_many_environments_on_several_threads_have_the_same_bits() -> None:
    keywords = {**SHORT, "num_threads": 2}
    ours, theirs = (make(FORCE, STATEFUL, 200, **keywords) for make in (compiled, in_numpy))
    assert assert_same_steps(ours, theirs, 9) >= 1
    assert has_code(ours)


@pytest.mark.parametrize("how", [*COPIES, "state"])
@pytest.mark.parametrize("steps", [0, 1, 4])
def test_copy_and_saved_state_go_on_as_the_original(how: str, steps: int) -> None:
    """Before the mode was called first, after it, and from a step of compiled code on."""
    env = compiled(FORCE, STATEFUL, **SHORT)
    seen, _ = env.reset(seed=21)
    actions = random_actions(env, 6)
    for action in actions[:steps]:
        seen = env.step(action)[0]
    if how == "state":
        clone = compiled(FORCE, STATEFUL, **SHORT)
        assert_same(clone.set_state(env.get_state()), seen, "observation")
    else:
        clone = COPIES[how](env)
    for action in actions[steps:]:
        assert_same(clone.step(action), env.step(action), how)
    assert stepped_in_code(clone)
    assert stepped_in_code(env)


@pytest.mark.parametrize(
    ("environment_id", "mode"), [(FORCE, STATEFUL), ("PRP-JointTracking-v0", "joint_inverse_dynamics")]
)
def test_state_is_restored_in_the_midst_of_an_episode(environment_id: str, mode: str) -> None:
    ours, theirs = (make(environment_id, mode, **SHORT) for make in (compiled, in_numpy))
    actions = random_actions(ours, 6)
    for env in (ours, theirs):
        env.reset(seed=1)
        env.step(actions[0])
        env.step(actions[1])
    states = [env.get_state() for env in (ours, theirs)]
    for _ in range(2):
        for action in actions[2:]:
            assert_same(ours.step(action), theirs.step(action), "step")
        for env, state in zip((ours, theirs), states, strict=True):
            env.set_state(state)
    assert_same(ours.set_state(states[1]), theirs.set_state(states[0]), "observation")
    assert_same(ours.step(actions[2]), theirs.step(actions[2]), "step")
    assert_same(ours.reset(seed=2), theirs.reset(seed=2), "observation")
    assert_same(ours.step(actions[3]), theirs.step(actions[3]), "step")


def test_listener_hears_every_period_and_changes_nothing() -> None:
    ours, theirs = (make(FORCE, STATEFUL, **SHORT) for make in (compiled, in_numpy))
    for env in (ours, theirs):
        env.reset(seed=4)
    heard: list[Step] = []
    for count, action in enumerate(random_actions(ours, 6)):
        ours.loop.listen(heard.append if count in (2, 3) else None)
        assert_same(ours.step(action), theirs.step(action), f"step {count}")
        assert stepped_in_code(ours) == (count not in (0, 2, 3))
        for name in SHOWN:
            assert_same(getattr(ours, name), getattr(theirs, name), f"{name} {count}")
    assert len(heard) == 2 * 10


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_action_that_is_not_finite_is_refused_and_changes_nothing(wrong: float) -> None:
    ours, theirs = (make(FORCE, STATEFUL, **SHORT) for make in (compiled, in_numpy))
    for env in (ours, theirs):
        env.reset(seed=4)
    actions = random_actions(ours, 4)
    refused = actions[0].copy()
    refused[1, 0] = wrong
    for action in actions:
        assert_same(ours.step(action), theirs.step(action), "step")
        with pytest.raises(NonFiniteError, match="environments \\[1\\]"):
            ours.loop.step(refused.astype(np.float64))


@pytest.mark.usefixtures("late_mode")
@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
@pytest.mark.parametrize("autoreset", MODES)
def test_environments_that_diverge_in_a_period_or_wait_are_those_of_numpy(
    autoreset: str, scenario: str
) -> None:
    keywords = {**WILD, **SHORT, "scenario": scenario, "engine": "compiled"}
    ours, theirs = (together(FORCE, autoreset, 4, **keywords) for _ in range(2))
    theirs.loop._may_compile = False
    assert_same(ours.reset(seed=20), theirs.reset(seed=20), "reset")
    rng, ends = np.random.default_rng(1), 0
    for count in range(12):
        when = [violent_in(period) for period in rng.choice([NEVER, NEVER, *range(1, 40)], 4).tolist()]
        action: Array = np.stack([np.array(when), rng.uniform(-1.0, 1.0, 4)], axis=1)
        found, expected = ours.step(action), theirs.step(action)
        assert_same(found, expected, f"step {count}")
        ended, ends = found[2] | found[3], ends + int(found[2].sum())
        if autoreset == "Disabled" and ended.any():
            again = [env.reset(options={"reset_mask": ended.copy()}) for env in (ours, theirs)]
            assert_same(again[0], again[1], f"reset {count}")
    assert ends >= 4
    assert has_code(ours)
    assert not has_code(theirs)


@pytest.mark.usefixtures("late_mode")
def test_environment_that_has_diverged_cannot_be_stepped() -> None:
    env = compiled(FORCE, WILD["action_mode"], 2, torque_limit=None, **SHORT)
    env.reset(seed=0)
    env.step(np.full((2, 2), NEVER))
    assert env.step(np.array([[violent_in(13), 1.0], [NEVER, 1.0]]))[2].tolist() == [True, False]
    assert stepped_in_code(env)
    with pytest.raises(EpisodeError, match=r"\[0\] cannot be stepped"):
        env.loop.step(np.zeros((2, 2)))


def test_environment_that_waits_for_its_reset_is_left_as_it_is() -> None:
    env = compiled(FORCE, STATEFUL, 2, **SHORT)
    env.reset(seed=0)
    action = np.ones((2, env.loop.action_size))
    env.step(action)
    env.step(action)
    before = env.physics.joint_position.copy(), env.ground_truth
    env.loop.step(action, np.array([True, False]))
    assert stepped_in_code(env)
    for old, new in zip(before, (env.physics.joint_position, env.ground_truth), strict=True):
        assert_same(new[0], old[0], "the one that waits")
        assert (new[1] != old[1]).any()


class Branching(LateMode):
    """A mode that branches on an action."""

    def torque(self, action: Any, observation: Any, memory: Any, starts: Any) -> Any:
        torque, after = super().torque(action, observation, memory, starts)
        return (-torque if action[0, 1] > 0.0 else torque), after


class Counting(LateMode):
    """A mode that keeps a count beside its memory."""

    count = 0

    def torque(self, action: Any, observation: Any, memory: Any, starts: Any) -> Any:
        object.__setattr__(self, "count", self.count + 1)
        torque, after = super().torque(action, observation, memory, starts)
        return torque * (self.count % 3), after


class WithTable(LateMode):
    """A mode whose memory is a dictionary."""

    def torque(self, action: Any, observation: Any, memory: Any, starts: Any) -> Any:
        torque, after = super().torque(action, observation, memory and memory["all"], starts)
        return torque, {"all": after}


class Infinite(LateMode):
    """A mode whose torque is not finite after some periods."""

    def torque(self, action: Any, observation: Any, memory: Any, starts: Any) -> Any:
        torque, after = super().torque(action, observation, memory, starts)
        return np.where(after[:, :1] > 25.0, np.nan, torque), after


class KeepingTask(LateMode):
    """A mode that reads the numbers of the running episodes."""

    def torque(self, action: Any, observation: Any, memory: Any, starts: Any) -> Any:
        torque, after = super().torque(action, observation, memory, starts)
        task = self.task  # type: ignore[attr-defined]
        return torque * np.sign(task.reference(np.zeros(len(action)))[:, :1]), after


class Entry(LateEntry):
    """Makes modes that know their task."""

    def make(self, ending: str, setup: ModeSetup) -> ActionMode:
        mode = super().make(ending, setup)
        object.__setattr__(mode, "task", setup.task)
        return mode


@pytest.fixture
def registered() -> Iterator[Callable[[type[LateMode]], str]]:
    """Registers a kind of mode for one test."""

    def register(kind: type[LateMode]) -> str:
        entry = Entry(kind) if kind is KeepingTask else LateEntry(kind)
        register_action_mode(ActionModeSpec("registered", "a mode of another package", entry))
        return "registered"

    yield register
    ACTION_MODES.unregister("registered")


@pytest.mark.parametrize("kind", [Branching, Counting, WithTable, KeepingTask])
def test_mode_that_cannot_be_traced_is_computed_by_numpy(kind: type[LateMode], registered: Any) -> None:
    keywords = {**SHORT, "torque_limit": None}
    mode = registered(kind)
    ours, theirs = (make(FORCE, mode, **keywords) for make in (compiled, in_numpy))
    assert_same(ours.reset(seed=5), theirs.reset(seed=5), "reset")
    rng = np.random.default_rng(0)
    for _ in range(4):
        action = np.stack([np.full(3, NEVER), rng.uniform(-1.0, 1.0, 3)], axis=1)
        assert_same(ours.step(action), theirs.step(action), "step")
    assert not has_code(ours)


def test_torque_of_the_inner_controller_that_is_not_finite_is_refused(registered: Any) -> None:
    mode, errors = registered(Infinite), []
    for make in (compiled, in_numpy):
        env = make(FORCE, mode, 2, **{**SHORT, "torque_limit": None})
        env.reset(seed=5)
        action = np.zeros((2, 2))
        env.step(action)
        env.step(action)
        with pytest.raises(NonFiniteError) as caught:
            env.step(action)
        errors.append(str(caught.value))
    assert errors[0] == errors[1]
