"""A learned policy: its network against formulas, the conventions of `predict`, its environment."""

import pickle
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import prp_gym
from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.policy.network import Network, NetworkShape
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.errors import InvalidValueError, ShapeError
from tests.conformance.test_public_api import in_fresh_python
from tests.support.synthetic_agents import ID, KEYWORDS, layout_of, observations, synthetic_policy

ROUNDING = 2e-6  # single precision: a few dozen operations on numbers of magnitude 1 to 10

POLICIES = {"without memory": synthetic_policy(), "with memory": synthetic_policy(memory=(5, 4))}


@pytest.fixture(params=POLICIES)
def policy(request: pytest.FixtureRequest) -> LearnedPolicy:
    return POLICIES[request.param]


@pytest.fixture
def env() -> Iterator[gymnasium.Env[Any, Any]]:
    with closing(gymnasium.make(ID, **KEYWORDS)) as made:
        yield made


def network(head: str = "clip", activation: str = "tanh", **tensors: Any) -> Network:
    """One input, one hidden unit, one output, unless a weight is given all are 1 and 0."""
    shape = NetworkShape(1, (), (1,), 1, activation, head)
    values = {
        name: np.full(size, float(name.endswith("weight"))) for name, size in shape.tensor_shapes().items()
    }
    values |= {name.replace("__", "."): value for name, value in tensors.items()}
    return Network(shape, {name: value.astype(np.float32) for name, value in values.items()})


@pytest.mark.parametrize(
    ("head", "expected"), [("clip", [1.0, -0.6, -1.0]), ("tanh", np.tanh([4.0, -0.6, -8.0]))]
)
def test_head_clips_or_squashes(head: str, expected: Any) -> None:
    tensors = {"layer_1__weight": np.array([[2.0]]), "layer_1__bias": np.array([0.0])}
    linear = network(head, "leaky_relu", **tensors, layer_0__weight=np.array([[1.0]]))
    values = np.array([[2.0], [-30.0], [-400.0]])
    np.testing.assert_allclose(linear(values, ())[0][:, 0], expected, atol=ROUNDING)


@pytest.mark.parametrize(
    ("activation", "formula"),
    [
        ("elu", lambda x: np.where(x > 0, x, np.exp(x) - 1)),
        ("leaky_relu", lambda x: np.where(x > 0, x, x / 100)),
        ("relu", lambda x: np.where(x > 0, x, 0)),
        ("silu", lambda x: x / (1 + np.exp(-x))),
        ("tanh", np.tanh),
    ],
)
def test_activation_is_its_formula(activation: str, formula: Any) -> None:
    x = np.linspace(-2.5, 2.5, 11)
    action, _ = network("tanh", activation)(x[:, None], ())
    np.testing.assert_allclose(action[:, 0], np.tanh(formula(x)), atol=ROUNDING)


def test_activations_take_large_numbers_without_a_warning() -> None:
    for activation in ("elu", "leaky_relu", "relu", "silu", "tanh"):
        action, _ = network("clip", activation)(np.array([[-1e6], [1e6]]), ())
        assert np.all(np.isfinite(action))


def test_memory_follows_the_equations_of_the_lstm() -> None:
    shape = NetworkShape(2, (3,), (), 1, "tanh", "tanh")
    rng = np.random.default_rng(2)
    tensors: dict[str, Any] = {name: rng.normal(size=size) for name, size in shape.tensor_shapes().items()}
    net, output, cell = Network(shape, tensors), np.zeros(3), np.zeros(3)
    memory = net.initial_memory(())
    for _ in range(5):
        x = rng.normal(size=2)
        action, memory = net(x, memory)
        gates = (
            tensors["lstm_0.input_weight"] @ x
            + tensors["lstm_0.state_weight"] @ output
            + tensors["lstm_0.bias"]
        )
        enter, keep, show = (1 / (1 + np.exp(-part)) for part in (gates[:3], gates[3:6], gates[9:]))
        cell = keep * cell + enter * np.tanh(gates[6:9])
        output = show * np.tanh(cell)
        np.testing.assert_allclose(memory[0], output, atol=ROUNDING)
        np.testing.assert_allclose(memory[1], cell, atol=ROUNDING)
        last = np.tanh(tensors["layer_0.weight"] @ output + tensors["layer_0.bias"])
        np.testing.assert_allclose(action, last, atol=ROUNDING)


def test_normaliser_scales_and_clips() -> None:
    normalizer = Normalizer(np.array([1.0, 0.0]), np.array([3.0, 0.0]), 1.0, 2.5)
    found = normalizer([[3.0, -2.0], [9.0, -7.0]])
    np.testing.assert_array_equal(found, [[1.0, -2.0], [2.5, -2.5]])


def test_tracking_errors_are_the_features(env: gymnasium.Env[Any, Any]) -> None:
    policy = synthetic_policy()
    observation, _ = env.reset(seed=1)
    parts = layout_of(ID).split(observation)
    errors = [parts[f"desired_joint_{kind}"] - parts[f"joint_{kind}"] for kind in ("position", "velocity")]
    features = np.concatenate([observation, *errors])
    expected, _ = policy.network(policy.normalizer(features), ())
    np.testing.assert_array_equal(policy.predict(observation)[0], expected)


def test_one_and_many_observations_give_the_same_actions(policy: LearnedPolicy) -> None:
    batch = observations(6)
    action, _ = policy.predict(batch)
    assert (action.shape, str(action.dtype)) == ((6, 3), "float32")
    assert np.all(np.abs(action) <= 1)
    for one, expected in zip(batch, action, strict=True):
        single, _ = policy.predict(one)
        assert (single.shape, str(single.dtype)) == ((3,), "float32")
        np.testing.assert_allclose(single, expected, atol=ROUNDING)
    grid, _ = policy.predict(batch.reshape(2, 3, -1))
    np.testing.assert_allclose(grid, action.reshape(2, 3, 3), atol=ROUNDING)


def test_policy_without_memory_has_no_state() -> None:
    action, state = synthetic_policy().predict(observations(2), None, np.array([True, False]))
    assert state is None
    np.testing.assert_array_equal(action, synthetic_policy().predict(observations(2))[0])


def test_state_starts_anew_in_the_rows_where_an_episode_starts() -> None:
    policy = POLICIES["with memory"]
    first, second = observations(3, 1), observations(3, 2)
    _, state = policy.predict(first)
    assert state is not None
    assert [part.shape for part in state] == [(3, 5), (3, 5), (3, 4), (3, 4)]
    kept, fresh = policy.predict(second, state)[0], policy.predict(second)[0]
    assert np.min(np.max(np.abs(kept - fresh), axis=-1)) > 100 * ROUNDING
    mixed, after = policy.predict(second, state, np.array([False, True, False]))
    np.testing.assert_array_equal(mixed, np.where([[False], [True], [False]], fresh, kept))
    assert after is not None
    for start in (np.array([True]), True):
        np.testing.assert_array_equal(policy.predict(second, state, start)[0], fresh)  # type: ignore[arg-type]
    np.testing.assert_array_equal(policy.predict(second, state, np.zeros(3, bool))[0], kept)


def test_state_given_is_left_as_it_is() -> None:
    policy = POLICIES["with memory"]
    _, state = policy.predict(observations(3))
    assert state is not None
    before = [part.copy() for part in state]
    policy.predict(observations(3, 1), state, np.array([True, False, True]))
    assert all(np.array_equal(old, new) for old, new in zip(before, state, strict=True))


def test_state_of_another_agent_or_number_of_environments_is_refused() -> None:
    policy = POLICIES["with memory"]
    _, state = policy.predict(observations(3))
    assert state is not None
    with pytest.raises(ShapeError, match=r"state has shape \(3, 5\); expected \(2, 5\)"):
        policy.predict(observations(2), state)
    with pytest.raises(ShapeError, match=r"state has shape \(2,\); expected a tuple of 4 arrays"):
        policy.predict(observations(3), state[:2])
    with pytest.raises(ShapeError, match=r"episode_start has shape \(2,\); expected \(3,\)"):
        policy.predict(observations(3), state, np.array([True, False]))


@pytest.mark.parametrize("shape", [(), (4,), (2, 4), (28,)])
def test_observation_of_another_size_is_refused(policy: LearnedPolicy, shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError, match=r"observation has shape .*; expected \(\.\.\., 27\)"):
        policy.predict(np.zeros(shape))


def test_dictionary_is_refused(policy: LearnedPolicy) -> None:
    with pytest.raises(
        InvalidValueError, match=r"observation is \['joint_position'\]; allowed: a flat array"
    ):
        policy.predict({"joint_position": np.zeros(3)})


def test_exploration_is_refused(policy: LearnedPolicy) -> None:
    with pytest.raises(InvalidValueError, match="deterministic is False; allowed: True"):
        policy.predict(observations(1), deterministic=False)


def test_policy_is_the_same_in_another_process(policy: LearnedPolicy) -> None:
    copy = pickle.loads(pickle.dumps(policy))
    np.testing.assert_array_equal(copy.predict(observations(3))[0], policy.predict(observations(3))[0])


def test_weights_cannot_be_changed_by_accident(policy: LearnedPolicy) -> None:
    with pytest.raises(ValueError, match="read-only"):
        policy.network.tensors["layer_0.bias"][0] = 1.0


def test_policy_is_evaluated_by_this_package_and_by_stable_baselines(policy: LearnedPolicy) -> None:
    with closing(policy.make_env(duration=0.1)) as env:
        assert 0.0 < prp_gym.evaluate(policy, env, 1).score.value <= 1.0
        mean, _ = evaluate_policy(policy, Monitor(env), n_eval_episodes=2)
        assert np.isfinite(mean)


def test_neither_torch_nor_pickle_is_needed_to_load_and_act(tmp_path: Path) -> None:
    policy = POLICIES["with memory"]
    save_agent(policy, tmp_path / "agent")
    code = f"""
import json, sys
for name in ("torch", "stable_baselines3", "sb3_contrib", "cloudpickle"):
    sys.modules[name] = None
import gymnasium, numpy, prp_gym, pickle, _pickle
env = gymnasium.make({ID!r}, **{KEYWORDS!r})
def poisoned(*_, **__):
    raise SystemExit("a pickle was opened")
pickle.load = pickle.loads = pickle.Unpickler = poisoned
_pickle.load = _pickle.loads = _pickle.Unpickler = poisoned
numpy.load = poisoned
policy = prp_gym.load_agent({str(tmp_path / "agent")!r})
policy.check_env(env)
observation, _ = env.reset(seed=0)
print(json.dumps([observation.tolist(), policy.predict(observation)[0].tolist()]))
"""
    observation, action = in_fresh_python(code)
    np.testing.assert_allclose(action, policy.predict(np.array(observation))[0], atol=ROUNDING)
