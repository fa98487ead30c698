"""The C source of control periods: actuators, sensors, errors and reward, traced, around the physics."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from prp_gym.envs.core.argument_checks import limit_actions
from prp_gym.envs.core.period_parts import PeriodParts, ReferenceRows
from prp_gym.envs.core.period_plan import LARGEST_STATE, PLAN
from prp_gym.errors import UntraceableError
from prp_gym.physics.batch_readings import READINGS
from prp_gym.physics.compiled_simulation import WORLD, CompiledSimulation
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import zeros
from prp_gym.robot.link import Link
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.elementary_functions import has_bits_of_numpy
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.lifting import numbers_of, trace_method
from prp_gym.symbolic.state_arrays import StateRows, attributes
from prp_gym.tasks.fields import ObservationLayout

CONSTANTS = (PRPArm, Link, ObservationLayout)
"""Classes of objects whose numbers are constants of compiled code."""

_HAND_WRITTEN = Path(__file__).with_name("compiled_period.c")


class PeriodSource:
    """Compiled control periods of a task in certain conditions.

    Args:
        loop: loop of such environments, all of which have been reset.

    Attributes:
        numbers: numbers of the task (P).
        rows: rows of what task and actuators keep from one period to the next.
        references: rows of the references; None where these are sampled ahead: where they cannot be traced,
            and with MuJoCo's physics where their bits would not be those of NumPy.
        begins: whether the start of episodes is compiled, too, with the bits of NumPy.
        has_bits_of_numpy: whether the compiled functions give the bits of NumPy on this machine.
        actuate: function from actions to torques.
        judge: function from the measurement to ground truth, observation, reward and `info`.
        text: C source of compiled_period.c, with `prp_run` if the physics is compiled, too.

    Raises:
        UntraceableError: errors that use more than arithmetic on arrays, or keep undeclared values.
    """

    def __init__(self, loop: Any) -> None:
        task, measured = loop.task, loop.physics.measurement_size
        self._parts = loop.period_parts().formulas()
        self.rows = StateRows(loop.period_parts().owners)
        self._sizes = {
            "joints": loop.joints,
            "measured": measured,
            "reference": task.layout.size - measured,
            "observed": task.layout.size,
            "ground_truth": task.ground_truth_layout.size,
            "info": len(loop.info_fields),
            "memory": self.rows.size,
            "largest_state": LARGEST_STATE,
            "physics": int(isinstance(loop.physics, CompiledSimulation)),
        }
        self._fields = task.ground_truth_layout.slices
        self._kind = tuple(self._sizes.items()), tuple(map(repr, self.rows.arrays))
        self.numbers = numbers_of(self._parts, CONSTANTS)
        self.references: ReferenceRows | None = None
        self.actuate, self.judge = self._traced_actuators(), self._traced_judge()
        functions = [self.actuate, self.judge, *self._traced_reference(task)]
        self._sizes["reference_numbers"] = self.references.size if self.references else 0
        self.has_bits_of_numpy = all(map(has_bits_of_numpy, functions))
        start: list[SymbolicFunction] = []
        if self.has_bits_of_numpy and self.references:
            start = self._traced_start()
        functions += start
        self.begins = bool(start)
        self._sizes["begins"] = len(start)
        physics = loop.physics.source if self._sizes["physics"] else f"{PREAMBLE}\n{WORLD}\n{READINGS}"
        self.text = self._source(physics, functions)

    def _source(self, physics: str, functions: Sequence[SymbolicFunction]) -> str:
        sizes = "".join(f"#define PRP_{name.upper()} {size}\n" for name, size in self._sizes.items())
        loop = _HAND_WRITTEN.read_text(encoding="utf-8")
        texts = [*map(c_function, functions), _record_fields(self._fields.values())]
        return "\n".join(["#include <string.h>", physics, sizes, PLAN, *texts, loop])

    def _traced_reference(self, task: Any) -> list[SymbolicFunction]:
        """From time to reference, see `references`."""
        with suppress(UntraceableError):
            rows = ReferenceRows(task.parts.reference)
            function = _traced_rows(rows)
            if self._sizes["physics"] or has_bits_of_numpy(function):
                self.references = rows
                return [function]
        return []

    def _traced_actuators(self) -> SymbolicFunction:
        """From actions to torques."""
        joints = self._sizes["joints"]

        def actuate(parts: PeriodParts, action: Any, noise: Any, memory: Any) -> Mapping[str, Any]:
            with self._kept(parts, memory) as kept:
                within, saturated = limit_actions(action, np.ones((1, joints)))
                command = within * parts.torque_limit
                torque = parts.actuators.transmit(command, noise)
            flags: Any = saturated
            results = {"command": command, "torque": torque, "saturated": flags.astype(np.float64)}
            return {**results, "after": kept()}

        shapes = {"action": (1, joints), "noise": (1, joints), "memory": (1, self.rows.size)}
        return trace_method("prp_actuate", actuate, self._parts, shapes, CONSTANTS, self._kind).function

    def _traced_judge(self) -> SymbolicFunction:
        """From the measurement to ground truth, observation, reward and `info`."""
        sizes = self._sizes

        def judge(parts: PeriodParts, memory: Any, **given: Any) -> Mapping[str, Any]:
            present = self._present(given, memory)
            with self._kept(parts, memory) as kept:
                parts.errors.advance(present)
                parts.errors.complete(present)
            errors = parts.errors.errors(present, given["command"])
            reward, info = parts.scoring(errors, present, given["saturated"], given["clock"], given["beyond"])
            parts.scoring.zero_reward(reward, info, given["ended"] != 0.0)
            observation = present[:, : sizes["observed"]].copy()
            parts.sensors.disturb(observation, given["error"])
            results = {"ground_truth": present, "observation": observation, "reward": reward, "info": info}
            over: Any = parts.scoring.truncated(given["clock"])
            return {**results, "truncated": over.astype(np.float64), "after": kept()}

        joints: tuple[int, ...] = (1, sizes["joints"])
        shapes: dict[str, tuple[int, ...]] = {
            "measured": (1, sizes["measured"]),
            "reference": (1, sizes["reference"]),
        }
        shapes |= {"command": joints, "saturated": joints, "clock": (1,), "beyond": joints, "ended": (1,)}
        shapes |= {"error": (1, 3), "memory": (1, sizes["memory"])}
        return trace_method("prp_judge", judge, self._parts, shapes, CONSTANTS, self._kind).function

    def _traced_start(self) -> list[SymbolicFunction]:
        """From the measurement at the start of an episode to the ground truth, where this can be traced."""
        sizes = self._sizes

        def begin(parts: PeriodParts, memory: Any, **given: Any) -> Mapping[str, Any]:
            present = self._present(given, memory)
            with self._kept(parts, memory) as kept:
                parts.errors.complete(present)
            return {"ground_truth": present, "after": kept()}

        shapes = {"measured": (1, sizes["measured"]), "reference": (1, sizes["reference"])}
        shapes |= {"memory": (1, sizes["memory"])}
        with suppress(UntraceableError):
            traced = trace_method("prp_start", begin, self._parts, shapes, CONSTANTS, self._kind).function
            if has_bits_of_numpy(traced):
                return [traced]
        return []

    def _present(self, given: Mapping[str, Any], like: Any) -> Any:
        """The ground truth (1, size) from measurement and reference, without the unobserved fields."""
        sizes = self._sizes
        present = zeros((1, sizes["ground_truth"]), like)
        present[:, : sizes["measured"]] = given["measured"]
        present[:, sizes["measured"] : sizes["observed"]] = given["reference"]
        return present

    @contextmanager
    def _kept(self, parts: PeriodParts, memory: Any) -> Iterator[Callable[[], Any]]:
        """Give parts what they keep, yield a reader of it, and refuse any other change of them."""
        self.rows.write(parts.owners, memory)
        before = [attributes(owner) for owner in parts.owners]
        yield lambda: self.rows.read(parts.owners)
        self.rows.require_unchanged(parts.owners, before)


def _traced_rows(rows: ReferenceRows) -> SymbolicFunction:
    """From time to reference; traced once for all references of one kind."""

    def refer(clock: Any, period: Any, row: Any) -> Mapping[str, Any]:
        return {"reference": rows.formula(row).sample(clock * period)}

    kind = rows.kind(CONSTANTS)
    known = _KNOWN.get(kind)
    if known is None:
        known = trace("prp_refer", refer, {"clock": (1,), "period": (1,), "row": (1, rows.size)})
        while len(_KNOWN) >= _MOST_KNOWN:
            _KNOWN.pop(next(iter(_KNOWN)), None)
        _KNOWN[kind] = known
    return known


_KNOWN: dict[Hashable, SymbolicFunction] = {}
_MOST_KNOWN = 64


def _record_fields(parts: Iterable[slice]) -> str:
    """A C function that records a ground truth at one of so many times, each field by itself."""
    copies = (
        f"    memcpy(kept + {part.start} * times + {part.stop - part.start} * at, present + {part.start},"
        f" {part.stop - part.start} * sizeof *kept);\n"
        for part in parts
    )
    head = "static inline void prp_record_fields(const double *present, long times, long at, double *kept)"
    return f"{head}\n{{\n{''.join(copies)}}}\n"
