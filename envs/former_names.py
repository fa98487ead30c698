"""Names of 0.1 that still work, with a `DeprecationWarning`, until 0.3."""

import warnings
from importlib import import_module
from typing import Any

from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.tasks.spec import TASKS

_OPTIONS = {
    "AdaptiveOptions": "prp_gym.envs.tasks.adaptive",
    "AdmittanceOptions": "prp_gym.envs.tasks.admittance",
    "ForceOptions": "prp_gym.envs.base.force_options",
    "ForcePositionOptions": "prp_gym.envs.tasks.force_position",
    "PoseTrackingOptions": "prp_gym.envs.tasks.pose_tracking",
    "StiffnessOptions": "prp_gym.envs.base.target_options",
    "TargetOptions": "prp_gym.envs.base.target_options",
    "TrackingOptions": "prp_gym.envs.tasks.joint_tracking",
}
"""Modules of the options classes."""

_SUFFIXES: dict[str, type[Any]] = {"VectorEnv": PRPVectorEnv, "Env": PRPEnv}
"""Endings of the names of the former environment classes, one of each for every task."""


def find_former_name(name: str) -> Any:
    """A name of `prp_gym.envs` as it was in 0.1.

    Args:
        name: Name of an environment class of one task, such as `ForceEnv`, or of an options class.

    Raises:
        AttributeError: a name that 0.1 did not have either.
    """
    if name in _OPTIONS:
        _warn(name, f"{_OPTIONS[name]}.{name}")
        return getattr(import_module(_OPTIONS[name]), name)
    for suffix, kind in _SUFFIXES.items():
        environment_id = f"PRP-{name.removesuffix(suffix)}-v0"
        if name.endswith(suffix) and environment_id in TASKS:
            _warn(name, f"{kind.__name__}({environment_id!r})")
            return _make_class(name, kind, environment_id)
    raise AttributeError(f"module 'prp_gym.envs' has no attribute {name!r}")


def _warn(name: str, instead: str) -> None:
    text = f"prp_gym.envs.{name} is deprecated and goes with 0.3; write {instead}"
    warnings.warn(text, DeprecationWarning, stacklevel=4)


def _make_class(name: str, kind: type[Any], environment_id: str) -> type[Any]:
    """A class whose instances are environments of one task."""

    def begin(self: Any, *arguments: Any, **keywords: Any) -> None:
        kind.__init__(self, environment_id, *arguments, **keywords)

    return type(name, (kind,), {"__init__": begin, "__doc__": f"Deprecated: `{environment_id}`."})
