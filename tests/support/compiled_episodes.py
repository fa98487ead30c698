"""Episodes of compiled code beside those of the loop that goes through them period by period."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import gymnasium
import numpy as np

from prp_gym import make_baseline
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.evaluation import Rollout
from prp_gym.evaluation.batch import _record, record_episodes
from prp_gym.evaluation.compiled_batch import record_compiled
from tests.evaluation.test_batch import assert_same

TRACKING = "PRP-JointTracking-v0"
SEEDS = (1, 2)


def made(environment_id: str, scenario: str = "realistic", **keywords: Any) -> Any:
    """An environment with the compiled engine."""
    return gymnasium.make(environment_id, engine="compiled", scenario=scenario, **keywords).unwrapped


def looped(policy: Any, env: Any, seeds: Sequence[int]) -> list[Rollout]:
    """Episodes of the loop."""
    return _record(policy, env, seeds)


def compiled(policy: Any, env: Any, seeds: Sequence[int]) -> list[Rollout]:
    """Episodes of the compiled code, which runs the policy itself."""
    rollouts = record_compiled(policy, env, seeds)
    assert rollouts is not None, f"{policy} on {env} is not run by compiled code"
    return rollouts


def assert_same_episodes(found: Sequence[Rollout], expected: Sequence[Rollout]) -> None:
    """Equal bits in all that is recorded, but for the time that the policy took."""
    for one, other in zip(found, expected, strict=True):
        assert_same(one, other)


@cache
def environment() -> Any:
    return made(TRACKING, duration=0.06)


@cache
def plain() -> Any:
    return make_baseline("joint_pd", environment())


def own(kind: type[JointPDController]) -> Any:
    """A new controller of a class, with the settings of the packaged one."""
    return kind(plain().interface, plain().settings)


class Altered(JointPDController):
    """The packaged controller with other torques."""

    def torque(self, observed: Any) -> Any:
        return self.alter(super().torque(observed), observed["joint_position"])

    def alter(self, torque: Any, q: Any) -> Any:
        return torque


def altered(alter: Callable[[Any, Any, Any], Any], **attributes: Callable[[], Any]) -> Callable[[], Any]:
    """Makes controllers that alter the torques, with attributes that are new for each of them."""

    def make() -> Any:
        policy = own(type("AlteredByTest", (Altered,), {"alter": alter}))
        for name, value in attributes.items():
            setattr(policy, name, value())
        return policy

    return make


def assert_same_outcome(make: Callable[[], Any]) -> Any:
    """New controllers have the same episodes, or the same error, in an evaluation and in the loop."""
    env = environment()
    found, expected = (
        outcome(lambda: record_episodes(make(), env, SEEDS)),
        outcome(lambda: looped(make(), env, SEEDS)),
    )
    if isinstance(expected, tuple):
        assert found == expected
    else:
        assert_same_episodes(found, expected)
    return expected


def outcome(run: Callable[[], Any]) -> Any:
    """What a function returns, or class and message of the error that it raises."""
    try:
        with np.errstate(all="ignore"):
            return run()
    except Exception as error:  # whatever it is
        return type(error), str(error)
