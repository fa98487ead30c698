"""Action modes are declared: a mode of one's own, and what a mode may command."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.action_modes import (
    ACTION_MODES,
    ANY_CONTROLLER,
    ActionField,
    ActionModeSpec,
    CommandInputs,
    ModeSetup,
    ResidualTorque,
    list_action_modes,
    make_action_mode,
)
from prp_gym.action_modes.modes.joint import JOINT_OFFSET
from prp_gym.action_modes.modes.pose import POSE_OFFSET
from prp_gym.baselines import BASELINES
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.robot import NOMINAL
from tests.support.mode_episodes import made, random_actions
from tests.support.vector_episodes import assert_same

GENTLE = ActionModeSpec(
    "gentle_adaptive",
    "moves the reference of adaptive control a little",
    CommandInputs("adaptive", (replace(JOINT_OFFSET, bound=(0.1, 0.01, 0.1)),)),
)
SINGLE_MODES = [(name, spec) for name, spec in ACTION_MODES.items() if not spec.is_family]


@pytest.fixture
def gentle() -> Iterator[str]:
    yield prp_gym.register_action_mode(GENTLE).name
    ACTION_MODES.unregister(GENTLE.name)


def test_registered_mode_is_listed_last_and_had_by_every_environment_that_serves_it(gentle: str) -> None:
    assert list_action_modes()[-1] == gentle
    for environment_id in prp_gym.list_envs():
        layout = made(environment_id).observation_layout
        serves = not BASELINES["adaptive"].missing_fields(layout)
        assert (gentle in list_action_modes(layout)) == serves
    env = made("PRP-JointTracking-v0", gentle, control_frequency=50)
    assert [field.bound for field in env.action_fields] == [(0.1, 0.01, 0.1)]


def test_registered_mode_runs_its_controller(gentle: str) -> None:
    """An action of 1 means what an action of a tenth of a wider bound does."""
    keywords: dict[str, Any] = {"control_frequency": 50, "duration": 0.2}
    wide = ActionModeSpec("wide_adaptive", "", CommandInputs("adaptive", (JOINT_OFFSET,)))
    prp_gym.register_action_mode(wide)
    try:
        ours, theirs = (made("PRP-JointTracking-v0", mode, **keywords) for mode in (gentle, "wide_adaptive"))
    finally:
        ACTION_MODES.unregister("wide_adaptive")
    ours.reset(seed=1)
    theirs.reset(seed=1)
    share = np.array([0.1 / 0.3, 0.01 / 0.05, 0.1 / 0.3])
    for action in random_actions(ours, 10):
        found, expected = ours.step(action)[0], theirs.step(action * share)[0]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-5)  # actions are rounded to 1e-7
    assert np.abs(found).max() > 0.1


def test_mode_that_is_gone_is_unknown() -> None:
    with pytest.raises(UnknownNameError, match="unknown action_mode 'gentle_adaptive'"):
        gymnasium.make("PRP-JointTracking-v0", action_mode="gentle_adaptive")


@pytest.mark.parametrize("name", ["torque", "impedance", "two words"])
def test_name_that_is_taken_or_cannot_be_one_is_refused(name: str) -> None:
    with pytest.raises(InvalidValueError, match=f"name of action_mode is '{name}'"):
        prp_gym.register_action_mode(replace(GENTLE, name=name))


@pytest.mark.parametrize(
    ("controller", "field"), [("compliance", "stiffness_factor"), ("joint_pd", "pose_offset")]
)
def test_input_that_the_controller_does_not_declare_is_refused_when_the_mode_is_made(
    controller: str, field: str
) -> None:
    wrong = ActionField(field, ("1",), "world", (0.05,), "of no effect")
    prp_gym.register_action_mode(ActionModeSpec("wrong", "", CommandInputs(controller, (wrong,))))
    try:
        with pytest.raises(UnknownNameError) as caught:
            made("PRP-Impedance-v0", "wrong")
    finally:
        ACTION_MODES.unregister("wrong")
    assert caught.value.kind == f"command input of controller {controller!r}"
    assert (caught.value.name, caught.value.valid) == (field, BASELINES[controller].command_inputs)


@pytest.mark.parametrize(("name", "spec"), SINGLE_MODES)
def test_mode_drives_inputs_that_its_controller_declares(name: str, spec: ActionModeSpec) -> None:
    fields = spec.entry.fields(NOMINAL.torque_limit, NOMINAL.torque_limit)
    assert {field.name for field in fields} <= set(BASELINES[spec.entry.controller].command_inputs)
    assert (spec.name, spec.label, spec.revision) == (name, name, 1)
    assert spec.summary


INPUTS = [(controller, name) for controller, spec in BASELINES.items() for name in spec.command_inputs]


SIZES = {"joint_offset": 3, "force_offset": 3, "approach_speed_factor": 1, "bandwidth_factor": 1}


@pytest.mark.parametrize(("controller", "name"), INPUTS)
def test_declared_input_changes_the_torques_of_its_controller(controller: str, name: str) -> None:
    """So a mode that names a declared input has an effect."""
    env = made("PRP-ForcePosition-v0", scenario="report")
    size, factor = SIZES.get(name, 5), name.endswith("factor")
    field = ActionField(name, ("1",) * size, "world", (2.0 if factor else 0.02,) * size, "", factor=factor)
    mode = CommandInputs(controller, (field,)).make("", ModeSetup(env.task, 10.0 * env.torque_limit, 0.002))
    observation, layout = env.reset(seed=2)[0], env.observation_layout
    observation = observation + 0.01 * np.random.default_rng(0).normal(size=layout.size)  # some errors
    touching = name != "approach_speed_factor"
    observation[layout.index("contact_force")] = touching * 2.0 * layout.split(observation)["desired_force"]
    still, moved = (torques_of(mode, np.full((1, size), value), observation[None]) for value in (0.0, 1.0))
    assert np.any(moved != still)


def torques_of(mode: Any, action: Any, observation: Any) -> Any:
    """Of the first twenty periods."""
    memory, torques = None, []
    for period in range(20):
        torque, memory = mode.torque(action, observation, memory, np.array([period == 0]))
        torques.append(torque)
    return np.array(torques)


def test_family_has_a_mode_of_each_controller_and_one_label() -> None:
    family = ACTION_MODES["residual"]
    assert family.is_family
    assert (family.label, family.entry.controller) == ("residual:<controller>", ANY_CONTROLLER)
    assert family.entry.endings(None) == tuple(f":{controller}" for controller in BASELINES)
    assert "residual" not in list_action_modes()
    with pytest.raises(UnknownNameError, match="unknown action_mode 'residual'"):
        made("PRP-JointTracking-v0", "residual")


def test_family_of_another_share_is_one_line() -> None:
    prp_gym.register_action_mode(ActionModeSpec("nudge", "adds a little", ResidualTorque(0.05)))
    try:
        (field,) = made("PRP-JointTracking-v0", "nudge:joint_pd").action_fields
    finally:
        ACTION_MODES.unregister("nudge")
    np.testing.assert_allclose(field.bound, 0.05 * np.array(NOMINAL.torque_limit), rtol=1e-15)


@dataclass(frozen=True)
class Push:
    """A mode without a controller inside: the action is a share of the torque limits."""

    controller: str = ""

    def endings(self, layout: Any) -> tuple[str, ...]:
        return ("",)

    def fields(self, torque_limit: Any, nominal: Any) -> tuple[ActionField, ...]:
        return (ActionField("push", ("1",) * len(torque_limit), "joint", (0.5,) * len(torque_limit), ""),)

    def make(self, ending: str, setup: ModeSetup) -> Any:
        return _Pushed(self.fields(setup.torque_limit, setup.torque_limit))


@dataclass(frozen=True)
class _Pushed:
    fields: tuple[ActionField, ...]

    def torque(self, action: Any, observation: Any, memory: Any, starts: Any) -> tuple[Any, Any]:
        return self.fields[0].value(action), None


def test_mode_needs_no_controller() -> None:
    prp_gym.register_action_mode(ActionModeSpec("push", "is half a torque", Push()))
    try:
        env, plain = made("PRP-JointTracking-v0", "push"), made("PRP-JointTracking-v0")
    finally:
        ACTION_MODES.unregister("push")
    assert_same(env.reset(seed=0), plain.reset(seed=0), "reset")
    for action in random_actions(env, 5):
        assert_same(env.step(action)[0], plain.step(action.astype(np.float64) * 0.5)[0], "step")


def test_modes_are_made_for_a_task() -> None:
    env = made("PRP-Impedance-v0")
    mode = make_action_mode("impedance", ModeSetup(env.task, env.torque_limit, 0.002))
    assert mode.fields == (POSE_OFFSET,)


def test_environment_takes_no_function_by_name() -> None:
    with pytest.raises(UnknownNameError, match="unexpected keyword argument 'action_modes'"):
        gymnasium.make("PRP-Impedance-v0", action_modes="prp_gym.action_modes:make_action_mode")
