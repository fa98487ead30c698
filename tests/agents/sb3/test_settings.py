"""Type and bounds of a recipe's settings: what is allowed is taken as it is, all else is refused."""

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from prp_gym.agents.algorithms import ALGORITHMS, RecipeScope
from prp_gym.agents.sb3.arguments import constructor_arguments
from prp_gym.agents.sb3.setting_kinds import CountSetting, LayersSetting, NumberSetting, OptionalSetting
from prp_gym.agents.training.recipes import load_recipe, make_recipe
from prp_gym.errors import DataFileError, InvalidValueError, PRPError, UnknownNameError

ID = "PRP-Adaptive-v0"
ALL = sorted({(name, key) for name, spec in ALGORITHMS.items() for key in spec.settings()})
OF_NETWORKS = sorted(
    {(name, key) for name, spec in ALGORITHMS.items() for key in spec.policy_settings(spec.scope.policies[0])}
)
HOSTILE: list[Any] = [
    *("abc", "", "lin_", "lin_nan", "lin_inf", "lin_-1", "auto_nan", "os:system", "x" * 10_000),
    *(float("nan"), float("inf"), -float("inf"), 1e300, -12345.5, -(10**30), 10**30, 0.3j, b"1"),
    *([], [[]], [1e9], ["a"], {}, {"a": 1}, {"pi": [0]}, object(), print, type, [None]),
]


@pytest.mark.parametrize(
    ("algorithm", "override"),
    [
        *(("ppo", text) for text in ("n_epochs=0", "n_epochs=1.5", "gamma=.nan", "gamma=abc", "gamma=1.01")),
        *(("ppo", text) for text in ("gamma=-0.1", "gamma=true", "gamma=", "gamma=[0.9]", "gamma={a: 1}")),
        *(("ppo", text) for text in ("n_envs=1e9", "n_envs=0", "n_envs=.inf", "n_timesteps=.nan")),
        *(("ppo", text) for text in ("batch_size=0", "batch_size=-64", "batch_size=1e30", "n_steps=0")),
        *(("ppo", text) for text in ("learning_rate=0", "learning_rate=.inf", "learning_rate=lin_nan")),
        *(("ppo", text) for text in ("learning_rate=lin_-1", "learning_rate=11", "clip_range=lin_x")),
        *(("ppo", text) for text in ("ent_coef=auto", "ent_coef=-1", "normalize_advantage=1", "vf_coef=~")),
        *(("ppo", text) for text in ("policy_kwargs.net_arch=64", "policy_kwargs.net_arch=[0]")),
        *(("ppo", text) for text in ("policy_kwargs.net_arch=[64.5]", "policy_kwargs.net_arch=[5000]")),
        *(("ppo", text) for text in ("policy_kwargs.net_arch={pi: [8]}", "policy_kwargs.ortho_init=1")),
        ("ppo", "policy_kwargs.net_arch={pi: [8], qf: [8]}"),
        ("ppo", "policy_kwargs.net_arch=[8, 8, 8, 8, 8, 8, 8, 8, 8]"),
        ("ppo", "policy_kwargs.log_std_init=.nan"),
        *(("sac", text) for text in ("buffer_size=1e9", "buffer_size=0", "tau=0", "train_freq=0")),
        *(
            ("sac", text)
            for text in ("ent_coef=auto_x", "ent_coef=autos", "gradient_steps=-2", "target_entropy=x")
        ),
        *(("td3", text) for text in ("noise_std=-1", "noise_std=abc", "policy_delay=0")),
    ],
)
def test_setting_out_of_its_bounds_is_refused_with_name_value_and_bounds(
    algorithm: str, override: str
) -> None:
    with pytest.raises(InvalidValueError) as caught:
        load_recipe(algorithm, ID, overrides=[override])
    assert caught.value.what == override.partition("=")[0]
    assert caught.value.allowed


@pytest.mark.parametrize(
    "override",
    [
        *(
            "optimizer_class=torch.optim.SGD",
            "features_extractor_class=os:system",
            "optimizer_kwargs={lr: 1}",
        ),
        *(
            "policy_kwargs.optimizer_class=torch.optim.SGD",
            "policy_kwargs.features_extractor_class=os.system",
        ),
        *("policy_kwargs.features_extractor_kwargs={a: 1}", "policy_kwargs.lstm_kwargs={device: cuda}"),
        *("policy_kwargs.activation_fn=os.system", "policy_kwargs.activation_fn=torch.nn.ReLU"),
        *("policy=os:system", "policy=stable_baselines3.ppo:MlpPolicy", "policy=[MlpPolicy]", "policy=3"),
        *("device=cuda", "tensorboard_log=/tmp/x", "replay_buffer_class=os:system", "rollout_buffer_class=x"),
        *("replay_buffer_kwargs={a: 1}", "env=os:system", "verbose=2", "seed=1", "_init_setup_model=false"),
        *("policy_kwargs.use_sde=true", "callback=x", "normalize.path=x", "policy_kwargs.action_space=x"),
    ],
)
@pytest.mark.parametrize("algorithm", ["ppo", "recurrent_ppo", "sac"])
def test_what_is_not_declared_is_refused(algorithm: str, override: str) -> None:
    with pytest.raises(UnknownNameError):
        load_recipe(algorithm, ID, overrides=[override])


@pytest.mark.parametrize(("algorithm", "key"), ALL)
def test_no_value_of_any_kind_is_an_untyped_error(algorithm: str, key: str) -> None:
    for value in HOSTILE:
        entry = {
            "n_timesteps": 10,
            "n_envs": 1,
            "policy": ALGORITHMS[algorithm].scope.policies[0],
            key: value,
        }
        with pytest.raises((InvalidValueError, UnknownNameError)) as caught:
            make_recipe(algorithm, ID, entry)
        assert len(str(caught.value)) < 600


@pytest.mark.parametrize(("algorithm", "key"), OF_NETWORKS)
def test_no_value_of_a_network_is_an_untyped_error(algorithm: str, key: str) -> None:
    entry: dict[str, Any] = {
        "n_timesteps": 10,
        "n_envs": 1,
        "policy": ALGORITHMS[algorithm].scope.policies[0],
    }
    for value in HOSTILE:
        if key == "net_arch" and value == []:
            continue  # no hidden layer
        with pytest.raises((InvalidValueError, UnknownNameError)):
            make_recipe(algorithm, ID, {**entry, "policy_kwargs": {key: value}})


def test_whole_numbers_may_be_written_with_an_exponent() -> None:
    recipe = load_recipe("sac", ID, overrides=["buffer_size=1e4", "n_timesteps=1e6", "n_envs=2e0"])
    assert (recipe.settings["buffer_size"], recipe.n_timesteps, recipe.n_envs) == (10_000, 1_000_000, 2)
    assert type(recipe.settings["buffer_size"]) is int


def test_words_and_null_are_allowed_where_the_algorithm_takes_them() -> None:
    recipe = load_recipe(
        "sac", ID, overrides=["ent_coef=auto_0.1", "target_entropy=auto", "gradient_steps=-1"]
    )
    assert recipe.settings["ent_coef"] == "auto_0.1"
    assert load_recipe("sac", ID, overrides=["ent_coef=auto"]).settings["ent_coef"] == "auto"
    recipe = load_recipe("ppo", ID, overrides=["clip_range_vf=", "target_kl=~", "learning_rate=lin_1e-3"])
    assert (recipe.settings["clip_range_vf"], recipe.settings["target_kl"]) == (None, None)
    constructor_arguments(recipe.settings, 1)
    arch = load_recipe("ppo", ID, overrides=["policy_kwargs.net_arch={pi: [8], vf: [16, 8]}"])
    assert arch.settings["policy_kwargs"]["net_arch"] == {"pi": [8], "vf": [16, 8]}


@pytest.mark.parametrize(
    ("algorithm", "overrides", "what"),
    [
        ("tqc", ["top_quantiles_to_drop_per_net=25"], "top_quantiles_to_drop_per_net"),
        ("tqc", ["policy_kwargs.n_quantiles=2"], "top_quantiles_to_drop_per_net"),
        ("recurrent_ppo", ["batch_size=1"], "batch_size"),
        ("recurrent_ppo", ["n_envs=1", "n_steps=129", "batch_size=128"], "batch_size"),
        ("recurrent_ppo", ["n_envs=1", "n_steps=1"], "batch_size"),
    ],
)
def test_settings_that_together_give_nan_are_refused(algorithm: str, overrides: list[str], what: str) -> None:
    with pytest.raises(InvalidValueError) as caught:
        load_recipe(algorithm, ID, overrides=overrides)
    assert caught.value.what == what


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_setting_of_the_recipes_is_declared(algorithm: str) -> None:
    recipe = load_recipe(algorithm, ID)
    kinds = ALGORITHMS[algorithm].settings()
    for key, value in recipe.settings.items():
        if key != "policy_kwargs":
            assert kinds[key].read(key, value) == value


def test_algorithm_of_another_package_declares_its_own_settings() -> None:
    spec = replace(
        ALGORITHMS["ppo"],
        scope=RecipeScope(settings={"verbose": CountSetting(0, 2), "other": CountSetting(0, 2)}),
    )
    assert spec.settings().keys() - ALGORITHMS["ppo"].settings().keys() == {"verbose"}  # PPO has no `other`
    assert pickle.loads(pickle.dumps(spec)) == spec
    net = replace(spec, scope=RecipeScope(policy_settings={"use_expln": CountSetting(0, 1)}))
    assert "use_expln" in net.policy_settings("MlpPolicy")


def test_kinds_say_what_they_allow() -> None:
    assert NumberSetting(0, 1, above=True).allowed == "a number above 0 and at most 1"
    assert OptionalSetting(NumberSetting(0, 1), "auto").allowed == "a number from 0 to 1, or auto"
    assert "at most 8 sizes from 1 to 4096" in LayersSetting(("pi", "vf")).allowed


@pytest.mark.parametrize(
    "text",
    [
        "default: &a {n_envs: 1, policy: *a}",
        "default: !!python/object/apply:pathlib.Path.touch [{marker}]",
        "default: !!python/object/new:pathlib.Path [{marker}]",
        "default: {n_envs: !!python/name:os.system }",
        "!!python/module:this {}",
        "a0: &a0 [x,x,x,x,x,x,x,x,x,x]\na1: &a1 [*a0,*a0,*a0,*a0,*a0,*a0,*a0,*a0]\ndefault: *a1",
        "default: " + "[" * 50_000,
        "default: {gamma: 0.9, gamma: 0.8}",
        "default: 2001-01-01",
        "1: {n_envs: 1}",
        "",
        "\ufeffdefault: {}",
    ],
)
def test_recipe_file_with_more_than_plain_values_is_refused(tmp_path: Path, text: str) -> None:
    path, marker = tmp_path / "own.yml", tmp_path / "marker"
    path.write_text(text.replace("{marker}", str(marker)), encoding="utf-8")
    with pytest.raises(PRPError):
        load_recipe("ppo", ID, config=path)
    assert not marker.exists()


def test_override_with_a_tag_or_too_many_levels_is_refused() -> None:
    for text in (
        "gamma=!!python/object/apply:os.getcwd []",
        "gamma=" + "[" * 100,
        ".".join("a" * 100) + "=1",
    ):
        with pytest.raises(InvalidValueError, match="override"):
            load_recipe("ppo", ID, overrides=[text])


def test_recipe_file_that_would_never_end_is_refused() -> None:
    for name in ("/dev/full", "/dev/zero", "/dev", "/"):
        with pytest.raises(DataFileError, match="only a regular file is read"):
            load_recipe("ppo", ID, config=Path(name))
