"""`check_same`: whether a trained agent can act in an environment."""

from typing import Any

from prp_gym.agents.policy.agent_card import AgentCard
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError

_UNITS = {"control_frequency": "Hz"}


def check_same(card: AgentCard, env: Any) -> None:
    """Refuse an environment whose interface differs from that of an agent's training.

    Args:
        card: card of the agent.
        env: environment or vector environment of this suite, with or without wrappers, also those of
            Stable-Baselines3.

    Raises:
        InvalidValueError: an environment of another suite or id, or with another observation, action mode,
            control frequency or action size; observations that a wrapper has already normalised.
    """
    found, expected = _facts_of(env), _facts_on(card)
    for name, value in found.items():
        if value != expected[name]:
            allowed = f"{expected[name]!r}, with which the agent was trained"
            raise InvalidValueError(f"{name} of the environment", value, allowed, _UNITS.get(name, ""))
    if getattr(env, "norm_obs", False):
        raise InvalidValueError(
            "env", type(env).__name__, "observations as they are: the agent normalises them"
        )


def _facts_on(card: AgentCard) -> dict[str, Any]:
    """The interface in training; keywords that the card does not state had their defaults."""
    keywords, size = card.interface.all_keywords, sum(part.size for part in card.interface.observation)
    return {
        "id": card.task_id,
        "observation fields": tuple((part.name, part.size) for part in card.interface.observation),
        "action_mode": keywords.get("action_mode", EnvConfig.action_mode),
        "control_frequency": keywords.get("control_frequency", EnvConfig.control_frequency),
        "shape of an action": (card.action_size,),
        "shape of an observation": (size,),
    }


def _facts_of(env: Any) -> dict[str, Any]:
    """The same facts about an environment.

    Raises:
        InvalidValueError: an environment of another suite.
    """
    inner = getattr(env, "unwrapped", env)
    try:
        layout = _attribute(inner, "observation_layout")
        return {
            "id": _attribute(inner, "task").environment_id,
            "observation fields": tuple(
                (name, part.stop - part.start) for name, part in layout.slices.items()
            ),
            "action_mode": str(_attribute(inner, "config").action_mode),
            "control_frequency": _attribute(inner, "control_frequency"),
            "shape of an action": _space(env, "action_space").shape,
            "shape of an observation": _space(env, "observation_space").shape,
        }
    except AttributeError:
        raise InvalidValueError("env", env, "an environment of prp_gym, wrapped or not") from None


def _attribute(env: Any, name: str) -> Any:
    """An attribute of an environment, or of the first one in a vector environment."""
    return getattr(env, name) if hasattr(env, name) else env.get_attr(name)[0]


def _space(env: Any, name: str) -> Any:
    """The space of a single environment, also of one in a vector environment."""
    return getattr(env, f"single_{name}") if hasattr(env, f"single_{name}") else getattr(env, name)
