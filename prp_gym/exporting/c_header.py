"""`c_header`: a controller as one header in C99, which needs the mathematical library alone."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from prp_gym.baselines import Baseline
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.policy_state import LARGEST
from prp_gym.exporting.controller_functions import NEXT_STATE, ControllerFunctions
from prp_gym.exporting.header_comment import header_comment
from prp_gym.exporting.operation_counts import count_operations
from prp_gym.symbolic.c_source import c_literal, c_statements
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.operations import C_FUNCTIONS, REMAINDER
from prp_gym.tasks.fields import LARGEST_OBSERVATION

LONGEST_PREFIX = 45
"""So that no name is longer than the 63 characters that C99 promises to tell apart."""

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_FINITE_MATH = """\
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "this header must be compiled without -ffast-math and -ffinite-math-only: NaN would not be refused"
#endif
"""
_SHARED = f"""\
#ifndef PRP_GYM_C_FUNCTIONS
#define PRP_GYM_C_FUNCTIONS
{C_FUNCTIONS}#endif
"""


@dataclass(frozen=True)
class CHeader:
    """A controller as a header in C99.

    Attributes:
        prefix: what all names of the header begin with; the file is `<prefix>.h`.
        text: the header, in ASCII.
        observation_size: numbers of an observation.
        state_size: numbers of the state.
        torque_size: joint torques.
        operations: how often a step executes the operations of each kind, by their names.
    """

    prefix: str
    text: str
    observation_size: int
    state_size: int
    torque_size: int
    operations: Mapping[str, int]


def c_header(
    controller: Baseline[Any], prefix: str | None = None, facts: Mapping[str, str] | None = None
) -> CHeader:
    """A controller as one header in C99, with the torques of its formulas in double precision.

    The header defines `<prefix>_begin(observation, state)` and `<prefix>_step(observation, state, torque)`,
    both `static inline`, and the sizes and the control period as macros. The torques are those of
    `Baseline.control`, limited as `Baseline.act` limits them and without its rounding to single precision.
    The same controller gives the same text.

    Args:
        controller: controller with its gains, for an environment.
        prefix: what all names of the header begin with; None for one made from controller and task.
        facts: further facts by name for the comment at the top.

    Raises:
        InvalidValueError: a prefix that is no identifier of C, or too long.
        UntraceableError: a controller whose `predict` is its own, that uses more than arithmetic on arrays,
            or that keeps anything but its state.
    """
    functions = ControllerFunctions.of(controller)
    name = default_prefix(controller) if prefix is None else checked_prefix(prefix)
    sizes = {
        "OBSERVATION_SIZE": controller.interface.layout.size,
        "STATE_SIZE": functions.state_size,
        "TORQUE_SIZE": len(controller.interface.torque_limit),
    }
    guard = f"{name.upper()}_H"
    parts = [
        header_comment(name, controller, functions, facts or {}),
        f"#ifndef {guard}\n#define {guard}\n",
        "#include <math.h>\n",
        _FINITE_MATH,
        _macros(name, sizes, controller.interface.period),
        f"typedef char {name}_needs_double_of_64_bits[sizeof(double) == 8 ? 1 : -1];\n",
        *([_SHARED] if _needs_functions(functions) else []),
        _within(name),
        _begin(name, sizes, functions.begin),
        _step(name, sizes, functions.step),
        f"#endif /* {guard} */\n",
    ]
    return CHeader(
        name,
        "\n".join(parts),
        sizes["OBSERVATION_SIZE"],
        sizes["STATE_SIZE"],
        sizes["TORQUE_SIZE"],
        count_operations(functions.step),
    )


def default_prefix(controller: Baseline[Any]) -> str:
    """What all names of a header begin with: `prp_<controller>_<task>`, cut to the longest allowed length."""
    task = re.sub(r"^PRP-|-v\d+$", "", controller.interface.environment_id)
    own = controller.origin.controller.rpartition(":")[2]
    return f"prp_{_snake(own)}_{_snake(task)}"[:LONGEST_PREFIX].rstrip("_")


def checked_prefix(prefix: str) -> str:
    """A prefix that may begin names of C.

    Raises:
        InvalidValueError: another one.
    """
    if not _IDENTIFIER.fullmatch(prefix) or len(prefix) > LONGEST_PREFIX:
        allowed = f"up to {LONGEST_PREFIX} letters, digits and underscores of ASCII, a letter first"
        raise InvalidValueError("prefix", prefix, allowed)
    return prefix


def _snake(name: str) -> str:
    """A name as a part of an identifier, in small letters."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    return re.sub(r"[^A-Za-z0-9]+", "_", apart).strip("_").lower()


def _needs_functions(functions: ControllerFunctions) -> bool:
    nodes = (*functions.begin.nodes(), *functions.step.nodes())
    return any(node.operation is REMAINDER for node in nodes)


def _macros(name: str, sizes: Mapping[str, int], period: float) -> str:
    """Sizes and the control period [s]."""
    values = {**{key: str(size) for key, size in sizes.items()}, "PERIOD": f"{c_literal(period)} /* s */"}
    return "".join(f"#define {name.upper()}_{key} {value}\n" for key, value in values.items())


def _within(name: str) -> str:
    return f"""\
/* Whether numbers are finite and not above the largest magnitude. */
static inline int {name}_within(const double *numbers, int count, double largest)
{{
    int index, within = 1;
    for (index = 0; index < count; ++index) {{
        within &= fabs(numbers[index]) <= largest;
    }}
    return within;
}}
"""


def _begin(name: str, sizes: Mapping[str, int], function: SymbolicFunction) -> str:
    size = sizes["STATE_SIZE"]
    return f"""\
/* The state at the start of an episode; returns 0, or 1 if it refuses. */
static inline int {name}_begin(const double *observation, double *state)
{{
{_guarded(name, sizes, "        return 1;")}
{"".join(c_statements(function))}{_checked(name, size, "        return 1;")}    return 0;
}}
"""


def _step(name: str, sizes: Mapping[str, int], function: SymbolicFunction) -> str:
    size, joints = sizes["STATE_SIZE"], sizes["TORQUE_SIZE"]
    refuse = "".join(f"        torque[{joint}] = 0.0;\n" for joint in range(joints)) + "        return 1;"
    limited = f"\n        || !{name}_within(torque, {joints}, {c_literal(LARGEST)})"
    return f"""\
/* The joint torques of one control period, and the state a period later; returns 0, or 1 if it refuses. */
static inline int {name}_step(const double *observation, double *state, double *torque)
{{
{_guarded(name, sizes, refuse)}
{"".join(c_statements(function))}{_checked(name, size, refuse, limited)}    return 0;
}}
"""


def _guarded(name: str, sizes: Mapping[str, int], refuse: str) -> str:
    """The declaration of the state a period later, and the check of the observation."""
    size, largest = sizes["STATE_SIZE"], c_literal(LARGEST_OBSERVATION)
    state = f"    double {NEXT_STATE}[{size}];\n    int index;" if size else "    (void)state;"
    observed = f"{name}_within(observation, {sizes['OBSERVATION_SIZE']}, {largest})"
    return f"{state}\n    if (!{observed}) {{\n{refuse}\n    }}"


def _checked(name: str, size: int, refuse: str, more: str = "") -> str:
    """The check of the result, and the copy of the state a period later."""
    state = f"!{name}_within({NEXT_STATE}, {size}, {c_literal(LARGEST)})" if size else ""
    condition = f"{state}{more}" if state else more.strip().removeprefix("|| ")
    if not condition:
        return ""
    check = f"    if ({condition}) {{\n{refuse}\n    }}\n"
    if not size:
        return check
    copy = f"        state[index] = {NEXT_STATE}[index];\n"
    return f"{check}    for (index = 0; index < {size}; ++index) {{\n{copy}    }}\n"
