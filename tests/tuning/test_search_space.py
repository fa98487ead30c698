"""Search spaces: every controller has one on every environment where it runs, around its tuned settings."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym import list_envs
from prp_gym.agents.policy.agent_file import list_agents
from prp_gym.baselines import BASELINES, ControllerData, gain_sets, load_gains, make_baseline
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.registry import NOT_IN_THE_REPORT
from prp_gym.tuning import SearchSpace, TuningTask, make_candidates, start_gains
from tests.support.controller_episodes import COMBINATIONS, COVERING, environment

ROUNDING = 1e-12  # relative: a few products and powers in double precision


def space_of(controller: str, environment_id: str) -> SearchSpace:
    policy = make_baseline(controller, environment(environment_id))
    return SearchSpace.of(BASELINES[controller], policy.settings)


def corners(space: SearchSpace) -> Iterator[dict[str, float]]:
    """All parameters at an end, each alone at an end, and alternating ends."""
    low = {item.name: item.low for item in space.parameters}
    high = {item.name: item.high for item in space.parameters}
    yield from (low, high)
    for item in space.parameters:
        yield from ({**space.start, item.name: end} for end in (item.low, item.high))
        yield from ({**low, item.name: item.high}, {**high, item.name: item.low})


def test_every_controller_has_an_environment_and_every_environment_a_controller() -> None:
    assert {controller for _, controller in COMBINATIONS} == set(BASELINES)
    assert {name for name, _ in COMBINATIONS} == set(list_envs())


@pytest.mark.parametrize(("environment_id", "controller"), COMBINATIONS, ids=map("-".join, COMBINATIONS))
def test_centre_is_the_tuned_set_exactly(controller: str, environment_id: str) -> None:
    space = space_of(controller, environment_id)
    assert all(item.low < 1.0 < item.high and item.low > 0.0 for item in space.parameters)
    least = 1 if BASELINES[controller].chapter == NOT_IN_THE_REPORT else 2
    assert len(space.start) == len(space.parameters) >= least
    env = environment(environment_id)
    tuned, made = (
        make_baseline(controller, env),
        make_baseline(controller, env, gain_sets(controller)[0], **space.settings(space.start)),
    )
    for name, value in vars(tuned.settings).items():
        np.testing.assert_array_equal(vars(made.settings)[name], value, err_msg=name)


@pytest.mark.parametrize(("environment_id", "controller"), COMBINATIONS, ids=map("-".join, COMBINATIONS))
def test_every_corner_gives_a_controller_with_finite_actions(controller: str, environment_id: str) -> None:
    env, space = environment(environment_id), space_of(controller, environment_id)
    observation, _ = env.reset(seed=1)
    for factors in corners(space):
        policy = make_baseline(controller, env, "tuned", **space.settings(factors))
        action, _ = policy.predict(observation)
        assert np.isfinite(action).all()


@pytest.mark.parametrize(("environment_id", "controller"), COVERING, ids=map("-".join, COVERING))
def test_every_parameter_changes_settings_as_no_other_does(controller: str, environment_id: str) -> None:
    space = space_of(controller, environment_id)
    numbers = [name for name, value in space.settings(space.start).items() if not isinstance(value, str)]

    def flat(factors: dict[str, float]) -> Any:
        return np.concatenate([np.ravel(space.settings(factors)[name]) for name in numbers])

    base = flat(space.start)
    effects = [flat({**space.start, item.name: item.high}) - base for item in space.parameters]
    assert np.linalg.matrix_rank([effect / np.abs(effect).max() for effect in effects]) == len(effects)


def natural_frequency_and_damping(inertia: Any, damping: Any, stiffness: Any) -> tuple[Any, Any]:
    """ω = √(K/M), ζ = D/(2√(K M))."""
    return np.sqrt(stiffness / inertia), damping / (2.0 * np.sqrt(stiffness * inertia))


def test_impedance_parameters_are_inertia_bandwidth_and_damping_ratio() -> None:
    space = space_of("impedance", "PRP-Impedance-v0")
    factors = {
        "inertia_translation": 2.0,
        "inertia_rotation": 0.5,
        "bandwidth_translation": 3.0,
        "bandwidth_rotation": 0.25,
        "damping_ratio_translation": 0.7,
        "damping_ratio_rotation": 1.5,
    }
    assert set(factors) == set(space.start)
    before, after = space.settings(space.start), space.settings(factors)
    np.testing.assert_allclose(after["inertia"] / before["inertia"], [2.0] * 3 + [0.5] * 3, rtol=ROUNDING)
    was, now = (
        natural_frequency_and_damping(each["inertia"], each["damping"], each["stiffness"])
        for each in (before, after)
    )
    np.testing.assert_allclose(now[0] / was[0], [3.0] * 3 + [0.25] * 3, rtol=ROUNDING)
    np.testing.assert_allclose(now[1] / was[1], [0.7] * 3 + [1.5] * 3, rtol=ROUNDING)


def test_joint_parameters_move_their_joint_alone() -> None:
    space = space_of("joint_pd", "PRP-JointTracking-v0")
    factors = {**space.start, "bandwidth_joint_2": 2.0, "damping_ratio_joint_3": 3.0}
    before, after = space.settings(space.start), space.settings(factors)
    K_P, K_D = (after[name] / before[name] for name in ("proportional_gain", "derivative_gain"))
    np.testing.assert_allclose(K_P, [1.0, 4.0, 1.0], rtol=ROUNDING)
    np.testing.assert_allclose(K_D, [1.0, 2.0, 3.0], rtol=ROUNDING)


def test_adaptation_moves_masses_and_frictions_apart() -> None:
    space = space_of("adaptive", "PRP-JointTracking-v0")
    factors = {**space.start, "adaptation_inertia": 10.0, "adaptation_coulomb_friction": 0.1}
    ratio = space.settings(factors)["adaptation_gain"] / space.settings(space.start)["adaptation_gain"]
    np.testing.assert_allclose(ratio, [10.0] * 6 + [1.0] * 3 + [0.1] * 3, rtol=ROUNDING)
    link = space_of("adaptive", "PRP-Adaptive-v0")
    assert [name for name in link.start if name.startswith("adaptation")] == [
        "adaptation_inertia",
        "adaptation_viscous_friction",
        "adaptation_gravity_moment",
    ]


def test_target_impedance_of_the_task_is_the_centre_of_the_search() -> None:
    env = environment("PRP-Compliance-v0")
    target_impedance = env.unwrapped.task.target_impedance["stiffness"]
    space = space_of("admittance", "PRP-Compliance-v0")
    np.testing.assert_array_equal(space.centre.stiffness, target_impedance)  # type: ignore[attr-defined]
    moved = space.settings({**space.start, "frame_bandwidth_translation": 2.0})["stiffness"]
    np.testing.assert_allclose(moved / target_impedance, [4.0] * 3 + [1.0] * 3, rtol=ROUNDING)


@pytest.mark.parametrize(("rate", "gains"), [(500.0, "tuned"), (1000.0, "tuned"), (50.0, "tuned_50hz")])
def test_search_starts_from_the_set_for_its_rate(rate: float, gains: str) -> None:
    task = TuningTask("PRP-JointTracking-v0", "joint_pd", ("randomized",), rate, 10_000)
    assert start_gains(BASELINES[task.controller], task.environment_id, rate) == gains
    with closing(gymnasium.make(task.environment_id, control_frequency=rate)) as env:
        centre = vars(make_candidates(task, env).space)["centre"]
        expected = load_gains("joint_pd", gains, task.environment_id)["proportional_gain"]
        np.testing.assert_array_equal(vars(centre)["proportional_gain"], expected)


def test_controller_that_does_not_exist_is_refused() -> None:
    task = TuningTask("PRP-JointTracking-v0", "joint_pid", ("randomized",), 500.0, 10_000)
    with pytest.raises(UnknownNameError, match=r"unknown baseline 'joint_pid'\. Did you mean 'joint_pd'"):
        make_candidates(task, environment(task.environment_id))


@pytest.mark.parametrize("gain", [2.0, (1.0, 2.0, 3.0)])
def test_controller_without_a_search_space_has_a_factor_on_each_vector_setting(gain: Any) -> None:
    @prp_gym.controller
    def damper(joint_velocity: Any, *, damping: Any = gain, offset: float = 0.5) -> Any:
        return offset - damping * joint_velocity

    space = SearchSpace.of(damper, make_baseline(damper, environment("PRP-JointTracking-v0")).settings)
    assert [(item.name, item.low, item.high) for item in space.parameters] == [
        ("damping", 0.1, 10.0),
        ("offset", 0.1, 10.0),
    ]
    found = space.settings({"damping": 3.0, "offset": 0.1})
    np.testing.assert_allclose(found["damping"], 3.0 * np.array(gain), rtol=ROUNDING)
    np.testing.assert_allclose(found["offset"], 0.05, rtol=ROUNDING)


def test_settings_that_are_no_vectors_are_left_alone() -> None:
    spec = replace(BASELINES["operational_inverse_dynamics"], data=ControllerData())
    policy = make_baseline("operational_inverse_dynamics", environment("PRP-PoseTracking-v0"))
    assert set(SearchSpace.of(spec, policy.settings).start) == {
        *("proportional_gain", "derivative_gain", "integral_gain")
    }


def test_declared_limit_is_that_of_every_component(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    row = 'of = "joint"\nrange = [0.1, 10.0]\npowers = {derivative_gain = 1}\nlimit_high = "2 K_D dt < M"'
    file.write_text(f"[search.damping]\n{row}\n", encoding="utf-8")
    policy = make_baseline("joint_pd", environment("PRP-JointTracking-v0"))
    space = SearchSpace.of(replace(BASELINES["joint_pd"], data=ControllerData(file)), policy.settings)
    assert [item.limits for item in space.parameters] == [("", "2 K_D dt < M")] * 3


def test_controllers_are_intended_for_environments_on_which_they_run() -> None:
    for name, spec in BASELINES.items():
        if spec.chapter != NOT_IN_THE_REPORT:
            assert spec.data.intended, name
        assert {(item, name) for item in spec.data.intended} <= set(COMBINATIONS)
        assert len(set(spec.data.intended)) == len(spec.data.intended)
    tuned = {item for spec in BASELINES.values() for item in spec.data.intended}
    assert tuned >= {name for name in list_envs() if list_agents(name)}


@pytest.mark.parametrize(
    ("row", "what", "value"),
    [
        ("range = [0.1, 10.0]", "powers of search parameter 'speed'", None),
        ("range = [0.1, 10.0]\npowers = {gain = 1}", "powers of search parameter 'speed'", {"gain": 1}),
        ("powers = {derivative_gain = 1}", "range of search parameter 'speed'", None),
        ("range = [0.1]\npowers = {derivative_gain = 1}", "range of search parameter 'speed'", [0.1]),
        ("range = [2, 3]\npowers = {derivative_gain = 1}", "range of search parameter 'speed'", [2, 3]),
        ("range = [0, 3]\npowers = {derivative_gain = 1}", "range of search parameter 'speed'", [0, 3]),
        (
            'of = "pose"\nrange = [0.1, 10.0]\npowers = {derivative_gain = 1}',
            "components of search parameter 'speed'",
            ("pose", 3),
        ),
        (
            'of = "joint"\ngroups = ["joint_4"]\nrange = [0.1, 10.0]\npowers = {derivative_gain = 1}',
            "group of search parameter 'speed'",
            "joint_4",
        ),
        (
            "range = [0.1, 10.0]\npowers = {derivative_gain = 1}\nlimit_low = true",
            "limit_low of search parameter 'speed'",
            True,
        ),
        (
            "range = [0.1, 10.0]\npowers = {derivative_gain = 1}\nlimit_high = ' '",
            "limit_high of search parameter 'speed'",
            " ",
        ),
    ],
)
def test_parameter_that_does_not_fit_the_settings_is_refused(
    tmp_path: Path, row: str, what: str, value: object
) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(f"[search.speed]\n{row}\n", encoding="utf-8")
    policy = make_baseline("joint_pd", environment("PRP-JointTracking-v0"))
    with pytest.raises(InvalidValueError) as caught:
        SearchSpace.of(replace(BASELINES["joint_pd"], data=ControllerData(file)), policy.settings)
    assert (caught.value.what, caught.value.value) == (what, value)
