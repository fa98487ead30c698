"""The code that results depend on: versions, and digests of this package and of the plugins."""

import hashlib
from functools import cache
from pathlib import Path

import prp_gym
import prp_gym.agents
import prp_gym.baselines
import prp_gym.envs
from prp_gym.artifacts import list_versions
from prp_gym.plugins import loaded_plugins

_SOURCES = (prp_gym, prp_gym.envs, prp_gym.baselines, prp_gym.agents)
_SUFFIXES = (".py", ".toml", ".c", ".h")


def running_code() -> dict[str, str]:
    """Everything on which a record depends besides its job: versions, and digests of package and plugins."""
    plugins = {f"plugin {name}": digest for name, digest in loaded_plugins().items()}
    return {**list_versions(), "sources": source_digest(), **plugins}


@cache
def source_digest() -> str:
    """SHA-256 over the code and data files of this package, with their names."""
    digest = hashlib.sha256()
    for package in _SOURCES:
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*")):
            if path.suffix in _SUFFIXES and path.is_file():
                name = f"{package.__name__}/{path.relative_to(folder).as_posix()}"
                digest.update(f"{name}\0{path.stat().st_size}\0".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()
