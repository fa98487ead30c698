"""What tests of exported headers share: headers compiled strictly, observations, and Python's results."""

import ctypes
import subprocess
from collections.abc import Sequence
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines import CONTROLLERS, Baseline, list_baselines, make_baseline
from prp_gym.exporting import CHeader
from prp_gym.symbolic.compiler import find_compiler

Array = NDArray[np.float64]

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-pedantic")
"""No extension of the language, and no warning."""

NOISE = (0.0, 1e-4, 1e-3, 1e-2, 0.3)
"""Random changes of observations by the standard deviation of each of their numbers."""

_RUN = """
int {0}_run(const double *observation, long episodes, long periods, double *state, double *torque)
{{
    long episode, period;
    int refused = 0;
    for (episode = 0; episode < episodes; ++episode) {{
        refused += {0}_begin(observation, state);
        for (period = 0; period < periods; ++period) {{
            refused += {0}_step(observation, state, torque);
            observation += {1};
            torque += {2};
        }}
        state += {3};
    }}
    return refused;
}}
int {0}_one_begin(const double *observation, double *state) {{ return {0}_begin(observation, state); }}
int {0}_one_step(const double *observation, double *state, double *torque)
{{
    return {0}_step(observation, state, torque);
}}
"""


def compile_strictly(source: str, folder: Path, *options: str) -> Path:
    """The file that the compiler makes of a C source; the test fails at any warning."""
    path, made = folder / "program.c", folder / "program.so"
    path.write_text(source, encoding="ascii")
    command = [*find_compiler(), *STRICT, *options, "-I", str(folder), str(path), "-o", str(made), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return made


class CompiledHeader:
    """A header in machine code.

    Args:
        header: header.
        library: library that holds its code and that of `_RUN`.
    """

    def __init__(self, header: CHeader, library: ctypes.CDLL) -> None:
        self._header, self.state_size = header, header.state_size
        name = header.prefix
        self._run, self._begin, self._step = (
            library[f"{name}_run"],
            library[f"{name}_one_begin"],
            library[f"{name}_one_step"],
        )

    def run(self, observations: Array) -> tuple[Array, Array]:
        """Torques (E, T, joints) and final states (E, states) of sequences (E, T, size)."""
        episodes, periods, _ = given = observations.shape
        assert given[2] == self._header.observation_size
        state = np.full((episodes, self._header.state_size), np.nan)
        torque = np.full((episodes, periods, self._header.torque_size), np.nan)
        arrays = [_address(array) for array in (state, torque)]
        data = np.ascontiguousarray(observations)
        refused = self._run(_address(data), ctypes.c_long(episodes), ctypes.c_long(periods), *arrays)
        assert refused == 0
        return torque, state

    def begin(self, observation: Array, state: Array) -> int:
        """What `begin` returns; it changes the state."""
        return int(self._begin(_address(observation), _address(state)))

    def step(self, observation: Array, state: Array, torque: Array) -> int:
        """What `step` returns; it changes state and torque."""
        return int(self._step(_address(observation), _address(state), _address(torque)))


def _address(array: Array) -> ctypes.c_void_p:
    assert array.dtype == np.float64
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def compile_headers(headers: Sequence[CHeader], folder: Path, *options: str) -> list[CompiledHeader]:
    """Headers compiled into one program, each included twice."""
    source = ""
    for header in headers:
        (folder / f"{header.prefix}.h").write_text(header.text, encoding="ascii")
        name, upper = header.prefix, header.prefix.upper()
        sizes = (f"{upper}_{each}_SIZE" for each in ("OBSERVATION", "TORQUE", "STATE"))
        include = f'#include "{name}.h"\n'
        prototypes = f"""
int {name}_run(const double *, long, long, double *, double *);
int {name}_one_begin(const double *, double *);
int {name}_one_step(const double *, double *, double *);"""
        source += include * 2 + prototypes + _RUN.format(name, *sizes)
    made = compile_strictly(source, folder, "-shared", "-fPIC", "-ffp-contract=off", *(options or ("-O0",)))
    library = ctypes.CDLL(str(made))
    return [CompiledHeader(header, library) for header in headers]


@cache
def controllers(environment_id: str) -> dict[str, Baseline[Any]]:
    """The controllers that run on an environment and can be traced, by name."""
    with closing(gymnasium.make(environment_id)) as env:
        names = list_baselines(env.get_wrapper_attr("observation_layout"))
        traced = [name for name in names if CONTROLLERS.find(name).policy.compiled]
        return {name: make_baseline(name, env) for name in traced}


@cache
def recorded(environment_id: str, controller: str, episodes: int, periods: int) -> Array:
    """Observations (E, T, size) of episodes that a controller runs."""
    policy = controllers(environment_id)[controller]
    with closing(gymnasium.make_vec(environment_id, num_envs=episodes, scenario="realistic")) as env:
        observation, _ = env.reset(seed=5)
        state, start, found = None, np.ones(episodes, dtype=bool), []
        for _ in range(periods):
            found.append(observation.astype(np.float64))
            action, state = policy.predict(observation, state, start)
            observation, *_ = env.step(action)
            start = np.zeros(episodes, dtype=bool)
    return np.stack(found, axis=1)


def varied(observations: Array, copies: int) -> Array:
    """Copies of sequences (E, T, size) with random changes of several sizes, (copies·E, T, size)."""
    generator = np.random.default_rng(7)
    spread = observations.std(axis=(0, 1)) + 1e-3
    found = np.empty((copies, *observations.shape))
    for index, copy in enumerate(found):
        noise = NOISE[index % len(NOISE)] * spread
        np.add(observations, noise * generator.standard_normal(copy.shape), out=copy)
    return found.reshape(-1, *observations.shape[1:])


def of_python(controller: Baseline[Any], observations: Array) -> tuple[Array, Array]:
    """Torques of `control`, limited in double precision, and the final states, of sequences (E, T, size)."""
    split, limit, demanded = controller.interface.layout.split, controller.interface.torque_limit, []
    control = controller.control

    def noted(observed: Any, state: Any) -> Any:
        result = control(observed, state)
        demanded.append(np.clip(result[0], -limit, limit))
        return result

    vars(controller)["control"] = noted  # so that every formula is evaluated once
    try:
        state = controller.initial_state(split(observations[:, 0]))
        for period in range(observations.shape[1]):
            _, state = controller.act(split(observations[:, period]), state)
    finally:
        del vars(controller)["control"]
    rows = [part.reshape(len(observations), -1).astype(np.float64) for part in state]
    final = np.concatenate([np.zeros((len(observations), 0)), *rows], axis=1)
    return np.stack(demanded, axis=1), final
