"""Steps of action modes in compiled code beside those that NumPy computes around the same physics."""

from typing import Any

import numpy as np

from prp_gym.envs import PRPVectorEnv
from tests.support.vector_episodes import assert_same, together

SHOWN = ("ground_truth", "commanded_torque", "applied_torque")


def compiled(environment_id: str, mode: str, count: int = 3, **keywords: Any) -> PRPVectorEnv:
    """Environments in a mode with the compiled engine."""
    return together(environment_id, "Disabled", count, engine="compiled", action_mode=mode, **keywords)


def in_numpy(environment_id: str, mode: str, count: int = 3, **keywords: Any) -> PRPVectorEnv:
    """The same, of which NumPy computes all but the physics: every period, and the inner controller."""
    env = compiled(environment_id, mode, count, **keywords)
    env.loop._may_compile = False
    return env


def has_code(env: PRPVectorEnv) -> bool:
    """Whether there is compiled code for the steps of a mode."""
    return env.loop._code is not None  # type: ignore[attr-defined]


def stepped_in_code(env: PRPVectorEnv) -> bool:
    """Whether the last step of a mode, after which nothing was reset or saved, was one of compiled code."""
    return has_code(env) and bool(env.loop._code_keeps_memory)  # type: ignore[attr-defined]


def throw(env: PRPVectorEnv, index: int, ahead: float) -> None:
    """Put a joint of an environment at the bound of its velocity, which it leaves soon."""
    bound = env.physics._watched  # type: ignore[attr-defined]
    joints = len(bound) // 2
    position, velocity = env.physics.joint_position[[index]].copy(), np.zeros((1, joints))
    position[0, 0] = bound[0] - ahead * bound[joints]
    velocity[0, 0] = 0.999 * bound[joints]
    env.physics.reset(np.array([index]), position, velocity)


def assert_same_steps(ours: PRPVectorEnv, theirs: PRPVectorEnv, steps: int, seed: int = 3) -> int:
    """Random actions on both, from a reset on, with resets of those whose episodes end.

    In the third step the first environment is reset, and the last one is about to diverge in the fifth.

    Returns:
        the number of divergences.
    """
    assert_same(ours.reset(seed=seed), theirs.reset(seed=seed), "reset")
    rng, diverged, count = np.random.default_rng(seed), 0, ours.num_envs
    again = np.zeros(count, dtype=np.bool_)
    for step in range(steps):
        if step == 2:
            again[0] = True
        if again.any():
            seeds = [step + 10 * index for index in range(count)]
            begun = [
                env.reset(seed=list(seeds), options={"reset_mask": again.copy()}) for env in (ours, theirs)
            ]
            assert_same(begun[0], begun[1], f"reset {step}")
        if step == 4:
            throw(ours, count - 1, 0.0037)
            throw(theirs, count - 1, 0.0037)
        action = rng.uniform(-1.2, 1.2, ours.action_space.shape or ())
        found, expected = ours.step(action), theirs.step(action)
        assert_same(found, expected, f"step {step}")
        for name in SHOWN:
            assert_same(getattr(ours, name), getattr(theirs, name), f"{name} {step}")
        again, diverged = found[2] | found[3], diverged + int(found[2].sum())
    return diverged
