"""Cases of files: cards, weights, tuned controllers, gains, recipes, journals and results, damaged."""

import json
import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

import prp_gym
from bench.fuzz.strange import STRANGE
from bench.fuzz.target import Prepared, Target
from prp_gym.agents.policy.agent_file import TRAINED, save_agent
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.policy.network import Network
from prp_gym.agents.training.recipes import load_recipe
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.envs import PRPEnv
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.tuning.tuned_controller import load_tuned_controller

_AGENT = "PRP-Adaptive-v0/ppo_torque_seed_0"
_ROOT = TRAINED.parents[1]
_TASK = "PRP-Adaptive-v0"
_SEEDS = st.integers(0, 2**40)
_BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + n)}: &{chr(98 + n)} [{', '.join(['*' + chr(97 + n)] * 9)}]\n" for n in range(8)
)
_CONTENTS = (
    *(b"", b"\0", b"\xff\xfe", b"{}", b"[]", b"null", b"nan", b"0", b'"a"', b"[" * 5000, b'{"a":' * 5000),
    *(b"a: *a", b"a: &a [*a]", b"!!python/object/apply:os.system [true]", _BOMB.encode(), b"x" * 10**5),
    *(b"a = " + b"[" * 3000, b"a = 1e999", b"a = nan", b"1" * 5000, b'{"a": ' + b"9" * 5000 + b"}"),
)
_VALUES: tuple[object, ...] = (
    None,
    True,
    -1,
    0,
    10**400,
    1e308,
    -0.5,
    "",
    "a",
    "os:system",
    "torch:load",
    [],
    {},
    [[]],
    {"a": 1},
    [1] * 99,
)
_TEXTS = (
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "1000000000",
    "abc",
    "[]",
    "{}",
    "null",
    "true",
    "[1, a",
    "*a",
    "'",
)


def _damaged(content: bytes, seed: int) -> bytes:
    """A file's content with bytes flipped, cut, exchanged, or replaced as a whole."""
    rng = random.Random(seed)
    way = rng.randrange(6)
    if way == 0:
        return rng.choice(_CONTENTS)
    if way == 1:
        return content[: rng.randrange(len(content) + 1)]
    if way == 2:
        return _with_line(content, rng)
    if way in (3, 4) and content[:1] in b"{[":
        return _with_value(content, rng)
    flipped = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 8))):
        flipped[rng.randrange(len(flipped))] = rng.randrange(256)
    return bytes(flipped)


def _with_line(content: bytes, rng: random.Random) -> bytes:
    """The content with the value of one line replaced."""
    lines = content.split(b"\n")
    index = rng.randrange(len(lines))
    for sign in (b"=", b":"):
        if sign in lines[index]:
            lines[index] = lines[index].split(sign)[0] + sign + b" " + rng.choice(_TEXTS).encode()
            break
    return b"\n".join(lines)


def _with_value(content: bytes, rng: random.Random) -> bytes:
    """The JSON content with one value replaced, or one entry removed."""
    plain = json.loads(content)
    part = plain
    while True:
        keys = list(part) if isinstance(part, dict) else list(range(len(part)))
        if not keys:
            break
        key = rng.choice(keys)
        if isinstance(part[key], (dict, list)) and rng.random() < 0.7:
            part = part[key]
            continue
        if rng.random() < 0.2:
            del part[key]
        else:
            part[key] = rng.choice(_VALUES)
        break
    return json.dumps(plain).encode()


def _run_folder(folder: Path) -> RunFolder:
    run = RunFolder(folder / "run")
    run.begin(load_recipe("ppo", _TASK), {"seed": 0}, {})
    run.result.write_text('{"steps": 3, "score": 0.5}')
    run.progress.write_text('{"steps": 3}')
    return run


def _prepare_files(folder: Path) -> Prepared:
    env = PRPEnv(_TASK)
    stem = folder / "agent"
    for suffix in (".json", ".safetensors"):
        shutil.copy(TRAINED / f"{_AGENT}{suffix}", stem.with_suffix(suffix))
    run, recipe = _run_folder(folder), load_recipe("ppo", _TASK)
    readers: list[tuple[Path, bytes, Callable[[Path], object]]] = []

    def add(path: Path, source: Path, read: Callable[[Path], object]) -> None:
        content = source.read_bytes()
        path.write_bytes(content)
        readers.append((path, content, read))

    for suffix in (".json", ".safetensors"):
        path = stem.with_suffix(suffix)
        add(path, path, lambda path: prp_gym.load_agent(path).predict(np.zeros(5))[0])
    for tuned in sorted((_ROOT / "baselines" / "searches").glob("PRP-Adaptive*.json"))[:1]:
        add(folder / "tuned.json", tuned, lambda path: load_tuned_controller(path).make(env))
    gains = folder / "gains.toml"
    gains.write_text("source = 'here'\nstiffness = 9.0\ndamping = [1.0]\nminimum_frequency = 100\n")
    add(gains, gains, lambda path: prp_gym.make_baseline("joint_pd", env, gains=path))
    recipes = _ROOT / "agents" / "algorithms" / "ppo.yml"
    add(folder / "recipes.yml", recipes, lambda path: load_recipe("ppo", _TASK, config=path))
    add(folder / "results.json", run.result, lambda path: _read_plain(path))
    add(run.result, run.result, lambda path: (run.read_result(), run.read_steps()))
    for path in (run.config, run.run):
        add(path, path, lambda path: run.check_same(recipe, {"seed": 0}))

    def call(arguments: tuple[int, int]) -> object:
        index, seed = arguments
        path, content, read = readers[index]
        path.write_bytes(_damaged(content, seed))
        try:
            read(path)
        finally:
            path.write_bytes(content)
        return None

    return Prepared(st.tuples(st.integers(0, len(readers) - 1), _SEEDS), call)


def _read_plain(path: Path) -> object:
    """What a results file holds; one that is not JSON is a `ValueError`, which the stores expect."""
    try:
        return FileReader(RECORD_SIZE).read_json(path)
    except ValueError:
        return None


def _prepare_overrides(_: Path) -> Prepared:
    keys = [*load_recipe("ppo", _TASK).to_plain(), "gamma", "learning_rate", "policy_kwargs.net_arch", "a.b"]

    def call(arguments: tuple[str, str, str]) -> object:
        algorithm, key, value = arguments
        load_recipe(algorithm, _TASK, overrides=[f"{key}={value}"])
        return None

    values = st.sampled_from(_TEXTS) | st.text(max_size=5)
    return Prepared(st.tuples(st.sampled_from(["ppo", "sac"]), st.sampled_from(keys), values), call)


def _prepare_weights(folder: Path) -> Prepared:
    agent = prp_gym.load_agent(_AGENT)
    names = list(agent.network.tensors)

    def call(arguments: tuple[int, int, Any]) -> object:
        index, slot, value = arguments
        tensors = {name: np.array(tensor) for name, tensor in agent.network.tensors.items()}
        number = value if isinstance(value, float) else 1e38
        with np.errstate(over="ignore", invalid="ignore"):
            tensors[names[index % len(names)]].flat[0] = number * (1 + slot)
        changed = LearnedPolicy(agent.card, agent.normalizer, Network(agent.network.shape, tensors))
        save_agent(changed, folder / "weights")
        return prp_gym.load_agent(folder / "weights").predict(np.ones(5))[0]

    return Prepared(st.tuples(st.integers(0, 20), st.integers(0, 100), STRANGE), call)


FILES = (
    Target("weights", _prepare_weights, 0.3),
    Target("files", _prepare_files, 2.0),
    Target("overrides", _prepare_overrides, 0.5),
)
