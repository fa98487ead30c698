"""`require`: packages of the optional extra `agents`, imported on first use."""

from importlib import import_module
from typing import Any

from prp_gym.errors import MissingPackageError

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
        try:
            found = import_module(needed)
        except ModuleNotFoundError as error:
            if error.name not in (needed, needed.partition(".")[0]):
                raise  # the package is installed, but one of its own dependencies is not
            raise MissingPackageError(needed, "agents") from None
        module = found if needed == package else module
    return module
