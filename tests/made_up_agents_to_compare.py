"""Tiny agents in files, with a stand-in for what reads them: each always does the same."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym
from prp_gym.errors import InvalidValueError

CURVE = [
    {"steps": 1000, "seconds": 6.0, "score": 0.05, "violations": 2.0},
    {"steps": 2000, "seconds": 12.0, "score": 0.999, "violations": 3.0},
]


class ConstantAgent:
    """An agent that does the same whatever it observes."""

    def __init__(self, plain: dict[str, Any]) -> None:
        points = tuple(SimpleNamespace(**point) for point in plain["curve"])
        self.card = SimpleNamespace(
            interface=SimpleNamespace(environment_id=plain["environment"], keywords=plain["keywords"]),
            run=SimpleNamespace(seed=plain["seed"], curve=points),
        )
        self._action = np.array(plain["action"], dtype=np.float32)

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        return np.broadcast_to(self._action, (*observation.shape[:-1], self._action.size)).copy(), None

    def make_env(self, **overrides: Any) -> gymnasium.Env[Any, Any]:
        interface = self.card.interface
        made: gymnasium.Env[Any, Any] = gymnasium.make(
            interface.environment_id, **{**interface.keywords, **overrides}
        )
        return made


def load(name_or_path: str) -> ConstantAgent:
    try:
        return ConstantAgent(json.loads(Path(f"{name_or_path}.json").read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise InvalidValueError("agent", name_or_path, "a readable one") from error


def save(
    stem: Path,
    action: tuple[float, ...] = (0.0, 0.0, 0.0),
    seed: int = 0,
    environment_id: str = "PRP-JointTracking-v0",
    **keywords: Any,
) -> Path:
    """Write an agent's two files; the path without suffix."""
    stem.parent.mkdir(parents=True, exist_ok=True)
    plain = {
        "environment": environment_id,
        "keywords": {"control_frequency": 50.0, "scenario": "randomized", **keywords},
        "seed": seed,
        "curve": CURVE,
        "action": action,
    }
    stem.with_name(f"{stem.name}.json").write_text(json.dumps(plain), encoding="utf-8")
    stem.with_name(f"{stem.name}.safetensors").write_bytes(bytes([seed]))
    return stem


def use_stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let `prp_gym.load_agent` read these files."""
    monkeypatch.setattr(prp_gym, "load_agent", load, raising=False)
