"""Type and bounds of every setting that a recipe may give an algorithm or its networks."""

from collections.abc import Mapping

from prp_gym.agents.sb3.arguments import ACTIVATIONS, NOISES
from prp_gym.agents.sb3.setting_kinds import (
    ChoiceSetting,
    CountSetting,
    FlagSetting,
    LayersSetting,
    NumberSetting,
    OptionalSetting,
    PrefixedSetting,
    SettingKind,
    schedule,
)

TIMESTEPS = CountSetting(1, 10**12)
"""Number of training steps, summed over the parallel environments."""

ENVIRONMENTS = CountSetting(1, 16_384)
"""Number of parallel environments."""

_SHARE = NumberSetting(0.0, 1.0)
_COEFFICIENT = NumberSetting(0.0, 1e3)

SETTINGS: Mapping[str, SettingKind] = {
    "batch_size": CountSetting(1, 10**7),
    "clip_range": schedule(0.0, 10.0),
    "clip_range_vf": OptionalSetting(schedule(0.0, 1e6)),
    "ent_coef": _COEFFICIENT,
    "gae_lambda": _SHARE,
    "gamma": _SHARE,
    "learning_rate": schedule(0.0, 10.0),
    "max_grad_norm": NumberSetting(0.0, 1e6, above=True),
    "n_epochs": CountSetting(1, 10_000),
    "n_steps": CountSetting(1, 10**6),
    "normalize_advantage": FlagSetting(),
    "rms_prop_eps": NumberSetting(0.0, 1.0, above=True),
    "stats_window_size": CountSetting(1, 10**6),
    "target_kl": OptionalSetting(NumberSetting(0.0, 1e3, above=True)),
    "use_rms_prop": FlagSetting(),
    "vf_coef": _COEFFICIENT,
}
"""Settings of algorithms without a replay buffer."""

REPLAY_SETTINGS: Mapping[str, SettingKind] = {
    "batch_size": CountSetting(1, 10**7),
    "buffer_size": CountSetting(1, 10**8),
    "ent_coef": OptionalSetting(PrefixedSetting(_COEFFICIENT, "auto_", "a first value to tune"), "auto"),
    "gamma": _SHARE,
    "gradient_steps": CountSetting(-1, 10**6),
    "learning_rate": schedule(0.0, 10.0),
    "learning_starts": CountSetting(0, 10**9),
    "n_steps": CountSetting(1, 10_000),
    "noise_std": NumberSetting(0.0, 10.0),
    "noise_type": ChoiceSetting(NOISES),
    "policy_delay": CountSetting(1, 10_000),
    "stats_window_size": CountSetting(1, 10**6),
    "target_entropy": OptionalSetting(NumberSetting(-1e3, 1e3), "auto"),
    "target_noise_clip": NumberSetting(0.0, 10.0),
    "target_policy_noise": NumberSetting(0.0, 10.0),
    "target_update_interval": CountSetting(1, 10**9),
    "tau": NumberSetting(0.0, 1.0, above=True),
    "top_quantiles_to_drop_per_net": CountSetting(0, 1000),
    "train_freq": CountSetting(1, 10**6),
}
"""Settings of algorithms with a replay buffer."""

_NETWORK: Mapping[str, SettingKind] = {
    "activation_fn": ChoiceSetting(tuple(ACTIVATIONS)),
    "log_std_init": NumberSetting(-20.0, 10.0),
    "share_features_extractor": FlagSetting(),
}

NETWORK_SETTINGS: Mapping[str, SettingKind] = {
    **_NETWORK,
    "enable_critic_lstm": FlagSetting(),
    "lstm_hidden_size": CountSetting(1, 4096),
    "n_lstm_layers": CountSetting(1, 8),
    "net_arch": OptionalSetting(LayersSetting(("pi", "vf"))),
    "ortho_init": FlagSetting(),
    "shared_lstm": FlagSetting(),
}
"""Settings of the networks of algorithms without a replay buffer."""

REPLAY_NETWORK_SETTINGS: Mapping[str, SettingKind] = {
    **_NETWORK,
    "n_critics": CountSetting(1, 100),
    "n_quantiles": CountSetting(1, 1000),
    "net_arch": OptionalSetting(LayersSetting(("pi", "qf"))),
}
"""Settings of the networks of algorithms with a replay buffer."""
