"""Names of the measured programs in tables and figures."""

from collections.abc import Mapping, Sequence
from typing import Any

from bench.rounds import REACHER

Row = Mapping[str, Any]

_KINDS = {
    "bare": "bare mj_step",
    "bare_all_cores": "bare mj_step on all cores",
    "single": "single environment",
    "sync": "SyncVectorEnv",
    "async": "AsyncVectorEnv",
    "dummy": "DummyVecEnv",
    "adapter": "make_sb3_vec_env",
}
_REACHER_SUBSTEPS = 2
_SUBSTEPS_PER_SECOND = 1000


def contender_name(row: Row) -> str:
    """Name of the program that is measured."""
    if row["kind"] == "native":
        return "native, all cores" if row["threads"] == 0 else "native, one thread"
    return _KINDS[row["kind"]]


def is_as_shipped(row: Row) -> bool:
    """Whether MuJoCo's clock has its default setting: off in this suite, on in all others."""
    own = row["environment"].startswith("PRP-") and not row["kind"].startswith("bare")
    return bool(row["clock"] != own)


def frequency_text(row: Row) -> str:
    """Control frequency."""
    return f"{row['control_frequency']:g} Hz"


def substeps(row: Row, peers: Sequence[Row] = ()) -> str:
    """Number of physics steps per environment step."""
    for peer in peers:
        if peer["environment"] == row["environment"]:
            return str(peer["substeps"])
    if row["environment"] == REACHER:
        return str(_REACHER_SUBSTEPS)
    return f"{_SUBSTEPS_PER_SECOND / row['control_frequency']:g}"


def count_text(value: float) -> str:
    """A rate [1/s] with three digits and a comma between thousands."""
    digits = max(0, len(str(int(value))) - 3)
    return f"{round(value, -digits):,.0f}"
