"""`require`: packages of the optional extra `agents`, imported on first use."""

from typing import Any

from prp_gym import extras

_FOUNDATIONS = ("torch", "stable_baselines3")


def require(package: str = "stable_baselines3") -> Any:
    """Import a package of the extra `agents`, after PyTorch and Stable-Baselines3.

    Args:
        package: import name of the package or module.

    Returns:
        the module.

    Raises:
        MissingPackageError: the package, PyTorch or Stable-Baselines3 is not installed.
    """
    module: Any = None
    for needed in dict.fromkeys((*_FOUNDATIONS, package)):
        found = extras.require(needed)
        module = found if needed == package else module
    return module
