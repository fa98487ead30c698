"""Cases of policies: make_baseline and settings, predict, evaluate, agents, registrations."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

import prp_gym
from bench.fuzz.strange import STRANGE, mostly, named, replaced
from bench.fuzz.target import Prepared, Target
from prp_gym.baselines.base.spec import CONTROLLERS
from prp_gym.envs import PRPEnv

_TASKS = ("PRP-JointTracking-v0", "PRP-Force-v0", "PRP-Adaptive-v0")
_AGENTS = (
    "PRP-Force-v0/ppo_variable_force_position_seed_0",
    "PRP-Adaptive-v0/ppo_torque_seed_0",
)
_PARTS = replaced(11)
_POSITIVE = st.one_of(st.floats(0.0, 1e9), st.sampled_from([5e-324, 1e-9, 1e9, 0.0, 1e308]))


def _prepare_settings(_: Path) -> Prepared:
    environments = [PRPEnv(task) for task in _TASKS]
    observations = [env.reset(seed=0)[0] for env in environments]
    runnable = [prp_gym.list_baselines(env.observation_layout) for env in environments]
    settings = {name: [f.name for f in fields(spec.settings_class)] for name, spec in CONTROLLERS.items()}

    def call(arguments: tuple[int, Any, Any, Any]) -> object:
        index, (name, overrides), gains, env = arguments
        chosen = environments[index] if env is None else env
        keywords = {} if gains is None else {"gains": gains}
        policy = prp_gym.make_baseline(name, chosen, **keywords, **overrides)
        return policy.predict(observations[index]) if chosen is environments[index] else None

    def settings_of(name: str) -> st.SearchStrategy[Any]:
        values = st.one_of(STRANGE, _POSITIVE, st.sampled_from(["current", "desired", "none"]))
        return st.tuples(st.just(name), st.just({}) | named(settings[name], values))

    def cases(index: int) -> st.SearchStrategy[Any]:
        own = st.one_of([settings_of(name) for name in runnable[index]])
        strange: st.SearchStrategy[Any] = st.tuples(STRANGE, st.just({}))
        gains = st.none() | mostly(named(["tuned", "stiffness", "minimum_frequency", "source"], STRANGE))
        return st.tuples(
            st.just(index), st.one_of(own, own, own, strange), gains, st.none() | mostly(st.none())
        )

    return Prepared(st.one_of([cases(index) for index in range(len(_TASKS))]), call)


def _prepare_predict(_: Path) -> Prepared:
    policies: list[Any] = []
    for task in _TASKS:
        env = PRPEnv(task, **({"scenario": "realistic"} if task == "PRP-Force-v0" else {}))
        observation = env.reset(seed=0)[0]
        for name in prp_gym.list_baselines(env.observation_layout):
            policies.append((prp_gym.make_baseline(name, env), observation))
    for name in _AGENTS:
        agent = prp_gym.load_agent(name)
        policies.append((agent, np.zeros(agent.card.interface.make_layout().size)))

    def call(arguments: Any) -> object:
        index, parts, (observation, state, start, rows) = arguments
        policy, usual = policies[index]
        if isinstance(state, dict) and not all(isinstance(part, int) for part in state):
            state = list(state)
        given = np.tile(usual, (rows, 1)) if rows else usual.copy()
        for slot, value in parts.items():
            given.flat[slot % given.size] = value
        _, before = policy.predict(given) if isinstance(state, dict) else (None, state)
        if isinstance(state, dict) and before is not None:
            before = tuple(np.array(part) for part in before)
            for slot, value in state.items():
                before[slot % len(before)].flat[slot % before[slot % len(before)].size] = value
        return policy.predict(given if observation is None else observation, before, episode_start=start)

    which = st.integers(0, len(policies) - 1)
    state = st.one_of(st.none(), _PARTS, STRANGE, st.tuples(STRANGE) | st.tuples(STRANGE, STRANGE, STRANGE))
    start = st.one_of(st.none(), st.just(np.array([True])), STRANGE)
    rest = st.tuples(st.none() | mostly(st.none()), state, start, st.sampled_from([0, 0, 1, 2]))
    return Prepared(st.tuples(which, replaced(80), rest), call)


def _prepare_api(_: Path) -> Prepared:
    env = PRPEnv("PRP-JointTracking-v0", duration=0.01)
    policy = prp_gym.make_baseline("joint_pd", env)
    calls: list[tuple[Callable[..., object], list[Any]]] = [
        (lambda *a: prp_gym.evaluate(*a).score, [policy, env, 2, 0]),
        (prp_gym.list_agents, [None]),
        (prp_gym.list_baselines, [None]),
        (prp_gym.load_agent, [_AGENTS[0]]),
        (prp_gym.load_plugins, [()]),
        (prp_gym.controller, [None]),
        (lambda name, summary: prp_gym.controller(name=name, summary=summary)(_brake), [None, None]),
        (prp_gym.register_task, [None]),
        (prp_gym.register_controller, [None]),
        (prp_gym.register_action_mode, [None]),
        (prp_gym.register_algorithm, [None]),
        (prp_gym.register_metric, [None]),
        (lambda name: CONTROLLERS.find(name), [None]),
        (lambda name: env.observation_layout.index(name), ["joint_position"]),
        (lambda value: env.observation_layout.split(value), [np.zeros(env.observation_layout.size)]),
    ]

    def call(arguments: tuple[int, int, Any]) -> object:
        index, slot, value = arguments
        function, values = calls[index]
        values = [value if number == slot % len(values) else old for number, old in enumerate(values)]
        result = function(*values)
        return None if function is prp_gym.load_agent or index == len(calls) - 1 else result

    return Prepared(st.tuples(st.integers(0, len(calls) - 1), st.integers(0, 3), STRANGE), call)


def _brake(joint_velocity: Any, *, damping: float = 1.0) -> Any:
    return -damping * joint_velocity


POLICIES = (
    Target("make_baseline", _prepare_settings, 2.0),
    Target("predict", _prepare_predict, 3.0),
    Target("api", _prepare_api),
)
