"""Exported agents act as Stable-Baselines3's models do; what cannot be exported is refused."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box
from stable_baselines3 import A2C
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn

from prp_gym.agents.policy.agent_file import load_agent, save_agent
from prp_gym.agents.policy.environments import environment_revision
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.training.export import export_agent, identity_normalizer
from prp_gym.errors import InvalidValueError, NonFiniteError, PRPError, ShapeError
from tests.support.synthetic_agents import ID, KEYWORDS, RUN, Trained, facts, layout_of, observations, trained

# single precision, summed in another order: 2⁻²⁴ of each of some dozens of products that are at most 10
SAME = 1e-5
ALGORITHMS = ("PPO", "SAC", "TD3", "TQC", "RecurrentPPO")

torch.set_num_threads(1)


@cache
def made(algorithm: str) -> tuple[Trained, LearnedPolicy]:
    source = trained(algorithm)
    return source, export_agent(source.model, source.normalizer, facts())


def assert_same_actions(source: Trained, policy: LearnedPolicy, observation: Any) -> None:
    expected, _ = source.expected(observation)
    action, _ = policy.predict(observation)
    assert (str(action.dtype), action.shape) == ("float32", expected.shape)
    np.testing.assert_allclose(action, expected, rtol=0, atol=SAME)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_actions_are_those_of_stable_baselines(algorithm: str) -> None:
    source, policy = made(algorithm)
    batch = observations(50)
    assert_same_actions(source, policy, batch)
    assert_same_actions(source, policy, batch[0])
    expected = source.expected(batch)[0]
    assert np.ptp(expected) > 0.5  # the comparison is one of unlike actions
    assert np.mean(np.abs(expected) < 0.99) > 0.3  # that are not all at their limits
    if algorithm == "PPO":
        assert np.any(np.abs(expected) == 1.0)  # some are


@pytest.mark.parametrize("layers", [1, 2])
def test_memory_is_that_of_stable_baselines_over_steps_and_episodes(layers: int) -> None:
    source = trained("RecurrentPPO", lstm_hidden_size=10, n_lstm_layers=layers)
    policy = export_agent(source.model, source.normalizer, facts())
    assert policy.card.network.memory == (10,) * layers
    rng = np.random.default_rng(1)
    ours: Any = None
    theirs: Any = None
    forgetful = []
    for step in range(12):
        batch = observations(6, seed=step)
        start = np.ones(6, dtype=bool) if step == 0 else rng.uniform(size=6) < 0.3
        expected, theirs = source.expected(batch, theirs, start)
        action, ours = policy.predict(batch, ours, start)
        np.testing.assert_allclose(action, expected, rtol=0, atol=SAME)
        forgetful.append(np.max(np.abs(policy.predict(batch)[0] - expected)))
    assert min(forgetful[1:]) > 100 * SAME  # the recurrent state matters
    single, _ = policy.predict(batch[0], tuple(part[0] for part in ours), np.array([False]))
    np.testing.assert_allclose(single, policy.predict(batch, ours)[0][0], rtol=0, atol=SAME)


@pytest.mark.parametrize("activation", [nn.Tanh, nn.ReLU, nn.ELU, nn.LeakyReLU, nn.SiLU])
def test_every_activation_is_that_of_torch(activation: type[nn.Module]) -> None:
    source = trained("PPO", activation_fn=activation)
    assert_same_actions(source, export_agent(source.model, source.normalizer, facts()), observations(20))


@pytest.mark.parametrize("layers", [[], [5], {"pi": [6, 4, 3], "vf": [2]}])
@pytest.mark.parametrize("algorithm", ["PPO", "RecurrentPPO"])
def test_any_number_of_layers_is_exported(layers: Any, algorithm: str) -> None:
    source = trained(algorithm, net_arch=layers)
    policy = export_agent(source.model, source.normalizer, facts())
    assert policy.card.network.hidden == tuple(layers["pi"] if isinstance(layers, dict) else layers)
    assert_same_actions(source, policy, observations(20))


def test_model_of_plain_observations_is_exported_as_such() -> None:
    source = trained("PPO", tracking=False)
    policy = export_agent(source.model, source.normalizer, facts())
    assert policy.card.interface.features == layout_of(ID).names
    assert_same_actions(source, policy, observations(20))


def test_model_without_normaliser_is_given_the_features_as_they_are() -> None:
    source = trained("PPO")
    size = source.model.observation_space.shape[0]
    policy = export_agent(source.model, identity_normalizer(size), facts())
    batch = 5.0 * observations(20)
    expected, _ = source.model.predict(source.features(batch), deterministic=True)
    np.testing.assert_allclose(
        policy.predict(batch)[0], expected, rtol=0, atol=5 * SAME
    )  # features five times as large


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_saved_and_loaded_agent_acts_as_the_model_to_the_last_bit_of_the_export(
    tmp_path: Any, algorithm: str
) -> None:
    _, policy = made(algorithm)
    save_agent(policy, tmp_path / "agent")
    loaded = load_agent(tmp_path / "agent")
    assert loaded.card == policy.card
    np.testing.assert_array_equal(loaded.predict(observations(9))[0], policy.predict(observations(9))[0])


def test_card_says_what_model_and_facts_know() -> None:
    source, policy = made("SAC")
    card = policy.card
    assert (card.algorithm, card.environment_id, card.action_size) == ("SAC", ID, 3)
    assert (card.network.hidden, card.network.activation, card.network.head) == ((16, 12), "relu", "tanh")
    assert card.network.inputs == source.features.size
    assert card.interface.features == source.features.names
    assert card.interface.keywords == policy.environment_keywords == KEYWORDS
    assert card.run is RUN
    assert card.versions["torch"] == torch.__version__
    assert {"python", "prp-gym", "stable-baselines3", "sb3-contrib", "numpy", "mujoco"} <= set(card.versions)


def test_card_stores_the_present_revision_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    source, policy = made("PPO")
    assert policy.card.interface.environment_revision == environment_revision(ID)
    monkeypatch.setattr("prp_gym.agents.training.export.environment_revision", {ID: 4}.__getitem__)
    exported = export_agent(source.model, source.normalizer, facts())
    assert exported.card.interface.environment_revision == 4


class Halving(BaseFeaturesExtractor):
    """Half of each feature."""

    def __init__(self, space: Box) -> None:
        super().__init__(space, space.shape[0])

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return 0.5 * observations


def refused(source: Trained, match: str, kind: type[PRPError] = InvalidValueError) -> None:
    with pytest.raises(kind, match=match):
        export_agent(source.model, source.normalizer, facts())


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_other_features_extractor_is_refused(algorithm: str) -> None:
    refused(trained(algorithm, features_extractor_class=Halving), "features extractor is 'Halving'.*Flatten")


@pytest.mark.parametrize(
    ("layer", "match"),
    [
        (
            nn.Sequential(nn.Linear(33, 16), nn.Tanh(), nn.Dropout(), nn.Linear(16, 12), nn.Tanh()),
            "layers of the",
        ),
        (nn.Sequential(nn.Linear(33, 16), nn.Tanh(), nn.Linear(16, 12), nn.ReLU()), "layers of the network"),
        (
            nn.Sequential(nn.Linear(33, 16), nn.Sigmoid(), nn.Linear(16, 12), nn.Sigmoid()),
            "layers of the network",
        ),
        (nn.Sequential(nn.Linear(33, 12, bias=False), nn.Tanh()), "layers of the network"),
        (nn.Sequential(nn.Tanh(), nn.Linear(33, 12)), "layers of the network"),
        (
            nn.Sequential(nn.Linear(33, 12), nn.LeakyReLU(0.3)),
            "difference between numpy's and torch's actions",
        ),
    ],
)
def test_layers_without_a_counterpart_are_refused(layer: nn.Module, match: str) -> None:
    source = trained("PPO")
    assert source.features.size == 33
    source.model.policy.mlp_extractor.policy_net = layer
    refused(source, match)


def test_algorithm_that_is_not_supported_is_refused() -> None:
    source = trained("PPO")
    refused(
        Trained(A2C("MlpPolicy", source.wrapper, device="cpu"), source.wrapper, source.features),
        "algorithm.*A2C",
    )


@pytest.mark.parametrize("algorithm", ["PPO", "SAC", "TQC", "RecurrentPPO"])
def test_generalised_exploration_is_refused(algorithm: str) -> None:
    source = trained(algorithm)
    source.model.use_sde = True
    refused(source, "use_sde is True")


def test_squashed_mean_is_refused() -> None:
    source = trained("PPO")
    source.model.policy._squash_output = True
    refused(source, "squash_output is True")


def test_lstm_of_another_kind_is_refused() -> None:
    refused(
        trained("RecurrentPPO", n_lstm_layers=2, lstm_kwargs={"dropout": 0.5}), "dropout of the LSTM is 0.5"
    )


@pytest.mark.parametrize(
    "space",
    [
        Box(-2, 2, (3,), np.float32),
        Box(-1, 2, (3,), np.float32),
        Box(0, 1, (3,), np.float32),
        Box(-1, 1, (3, 1), np.float32),
    ],
)
def test_other_action_space_is_refused(space: "Box[Any]") -> None:
    source = trained("PPO")
    source.model.action_space = space
    refused(source, r"action space of the model is .*; allowed: Box\(-1, 1")


def test_weights_that_are_no_numbers_are_refused() -> None:
    source = trained("PPO")
    with torch.no_grad():
        source.model.policy.action_net.bias[1] = torch.nan
    refused(source, "layer_2.bias", NonFiniteError)


def test_model_that_acts_otherwise_than_its_network_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    source = trained("PPO")
    inner = source.model.predict

    def shifted(*arguments: Any, **keywords: Any) -> Any:
        action, state = inner(*arguments, **keywords)
        return action + 2e-5, state

    monkeypatch.setattr(source.model, "predict", shifted)
    refused(source, "difference between numpy's and torch's actions is .*; allowed: at most 1e-05")


def test_model_of_another_observation_is_refused() -> None:
    source = trained("PPO")
    with pytest.raises(ShapeError, match=r"observation of the model.*\(33,\).*PRP-Force-v0"):
        export_agent(source.model, source.normalizer, facts("PRP-Force-v0"))


@pytest.mark.parametrize("name", ["mean", "variance"])
def test_normaliser_of_other_features_is_refused(name: str) -> None:
    source = trained("PPO")
    values: dict[str, Any] = {name: np.ones(5)}
    normalizer: Normalizer = replace(source.normalizer, **values)
    with pytest.raises(ShapeError, match=rf"{name} of the normalizer has shape \(5,\)"):
        export_agent(source.model, normalizer, facts())
