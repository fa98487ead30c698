"""Plugins: packages and modules that declare tasks, controllers, action modes, algorithms or metrics.

An installed package names its modules in the entry-point group `prp_gym.plugins`; the commands load them,
`import prp_gym` does not. A plugin is loaded by importing it; what it registers is found from then on.
"""

import hashlib
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

from prp_gym.checks import text
from prp_gym.errors import InvalidValueError, PluginError

GROUP = "prp_gym.plugins"
"""Entry-point group in which an installed package names its modules."""

_MOST_PLUGINS = 1000
_SUFFIXES = (".py", ".toml", ".yml")

_loaded: dict[str, str] = {}
"""Digests of the plugins that this process has loaded, by module."""


def load_plugins(modules: Iterable[str] = ()) -> list[str]:
    """Load the installed plugins, then others by name.

    Args:
        modules: names of modules that are installed or in the current folder.

    Returns:
        names of all plugins that this process has loaded.

    Raises:
        PluginError: a module that does not exist or fails as it is imported.
        InvalidValueError: names that are not texts.
    """
    installed = sorted({entry.module for entry in entry_points(group=GROUP)})
    load_modules(installed)
    load_modules(_names(modules))
    return list(_loaded)


def _names(modules: Iterable[str]) -> list[str]:
    """Names of modules, as users give them.

    Raises:
        InvalidValueError: one text, or anything else than names.
    """
    try:
        names = [] if isinstance(modules, (str, bytes)) else list(islice(modules, _MOST_PLUGINS))
    except Exception:  # no names, or whatever the value's own methods raise
        names = []
    if not names and not isinstance(modules, (tuple, list)):
        raise InvalidValueError("modules", modules, "names of modules")
    return names


def load_modules(modules: Iterable[str]) -> None:
    """Load some plugins and no others, as a worker process does for its parent.

    Raises:
        PluginError: a module that does not exist or fails as it is imported.
    """
    for name in modules:
        if text("name of plugin", name) not in _loaded:
            search_current_folder()
            _import(name)
            _loaded[name] = digest_module(name)


def loaded_plugins() -> dict[str, str]:
    """Digests of the plugins that this process has loaded, by module."""
    return dict(_loaded)


def search_current_folder() -> None:
    """Let modules of the current folder be imported, after the installed ones of the same name."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)


def digest_module(name: str) -> str:
    """SHA-256 over the code and data files of the top-level package of an imported module.

    Args:
        name: of the module.
    """
    found = hashlib.sha256()
    for label, path in _files(name.partition(".")[0]):
        content = path.read_bytes()
        found.update(f"{label}\0{len(content)}\0".encode())
        found.update(content)
    return found.hexdigest()


def error_line(error: BaseException, belongs: Callable[[str], bool]) -> tuple[str, int]:
    """File and line of the innermost call of an error in some files; an empty name where there is none.

    Args:
        error: that was raised.
        belongs: whether a file name is one of these files.
    """
    if isinstance(error, SyntaxError) and error.filename and belongs(error.filename):
        return error.filename, error.lineno or 0
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if belongs(frame.filename):
            return frame.filename, frame.lineno or 0
    return "", 0


def error_reason(error: BaseException) -> str:
    """Kind and message of an error on one line."""
    told = " ".join(str(error.msg if isinstance(error, SyntaxError) else error).split())
    return f"{type(error).__name__}: {told}" if told else type(error).__name__


def _import(name: str) -> None:
    try:
        import_module(name)
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and error.name and f"{name}.".startswith(f"{error.name}."):
            reason = f"there is no module {error.name!r}, neither installed nor in the current folder"
            raise PluginError(name, reason) from None
        own = {str(path) for _, path in _files(name.partition(".")[0])}
        file, line = error_line(error, own.__contains__)
        raise PluginError(name, error_reason(error), file, line) from error


def _files(top: str) -> Iterator[tuple[str, Path]]:
    """Code and data files of a top-level module or package, with names that do not depend on its folder."""
    spec = find_spec(top)
    folders = [Path(folder) for folder in (spec and spec.submodule_search_locations) or ()]
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix in _SUFFIXES and path.is_file():
                yield f"{top}/{path.relative_to(folder).as_posix()}", path
    if spec and spec.origin and not folders:
        yield f"{top}.py", Path(spec.origin)
