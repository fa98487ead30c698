"""Controllers that a user brings as a file or module of his own: found, loaded, and their errors reported.

The location of the code comes from the command line only; it is passed to worker processes, never stored.
Jobs, results and journals hold its label and its digest.
"""

import hashlib
import inspect
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn, Self

from prp_gym.errors import DataFileError, InvalidValueError, MissingFieldError, PRPError, UserCodeError
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.plugins import digest_module, error_line, error_reason, search_current_folder

_FILE = ".py"
_FORMS = "path/to/file.py:Name or package.module:Name"


@dataclass(frozen=True)
class UserCode:
    """Location of a user's controller.

    Attributes:
        label: label of the controller, `file.py:Name` without folders or `package.module:Name`.
        sha256: SHA-256 of the file, or of the code and data files of the module's top-level package.
        source: path of the file, or name of the module.
        attribute: name of the controller in it.
    """

    label: str
    sha256: str
    source: str
    attribute: str

    @classmethod
    def find(cls, text: str) -> Self:
        """The code that an option of the command line names.

        Args:
            text: `path/to/file.py:Name` or `package.module:Name`.

        Raises:
            InvalidValueError: another form, or a file that cannot be read.
            UserCodeError: a module that fails as it is imported.
        """
        source, _, attribute = text.rpartition(":")
        if not source or not attribute.isidentifier():
            raise InvalidValueError("controller", text, _FORMS)
        if not source.endswith(_FILE):
            _import(source)
            return cls(text, digest_module(source), source, attribute)
        path = Path(source).absolute()
        return cls(f"{path.name}:{attribute}", _sha256(_read(path)), str(path), attribute)

    def load(self) -> Any:
        """The object that the code defines under its name.

        Raises:
            InvalidValueError: a file that cannot be read, or other code than was found at first.
            UserCodeError: code that fails, or that does not define the name.
        """
        module = self._load_module()
        if not hasattr(module, self.attribute):
            names = ", ".join(name for name in vars(module) if not name.startswith("_"))
            reason = f"it does not define {self.attribute!r}; it defines: {names or 'nothing'}"
            raise UserCodeError(_shown(module, self.source), 1, reason)
        return getattr(module, self.attribute)

    def _load_module(self) -> ModuleType:
        if self.source.endswith(_FILE):
            return _load_file(Path(self.source), self.sha256)
        module = _import(self.source)
        self._check(digest_module(self.source))
        return module

    def _check(self, found: str) -> None:
        if found != self.sha256:
            what = f"SHA-256 of {self.label.rpartition(':')[0]!r}"
            raise InvalidValueError(what, found, f"that of when the command began, {self.sha256}")


@contextmanager
def report_failed_making(defined: Any, environment_id: str) -> Iterator[None]:
    """Report errors that a user's code raises while a policy is made from it.

    Args:
        defined: class whose module is the code.
        environment_id: id of the environment for which the policy is made.

    Raises:
        UserCodeError: in place of an error that was raised in code that is not this package's.
    """
    try:
        yield
    except Exception as error:
        where = _line_in(defined, error)
        if not where[0] and isinstance(error, PRPError):
            raise  # such as a setting that does not exist
        _report(defined, where, error, environment_id)


@contextmanager
def report_failed_acting(defined: Any, environment_id: str) -> Iterator[None]:
    """Report errors that a policy of a user's code raises while it computes actions.

    Args:
        defined: class whose module is the code.
        environment_id: id of the environment on which the policy acts.

    Raises:
        UserCodeError: in place of any error, if the code is not this package's.
    """
    try:
        yield
    except Exception as error:
        _report(defined, _line_in(defined, error), error, environment_id)


def definition(defined: Any, otherwise: str = "") -> tuple[str, int]:
    """File and first line of a class or function.

    Args:
        defined: the class or function.
        otherwise: file of anything else.
    """
    code = getattr(getattr(defined, "function", defined), "__code__", None)
    if code is not None:
        return code.co_filename, code.co_firstlineno
    try:
        return str(inspect.getsourcefile(defined)), inspect.getsourcelines(defined)[1]
    except (OSError, TypeError):
        return otherwise, 1


def _report(defined: Any, where: tuple[str, int], error: Exception, environment_id: str) -> NoReturn:
    """Raise an error of this package's code or a reported one as it is, any other as the user's."""
    if _top(defined) == "prp_gym" or isinstance(error, (UserCodeError, MissingFieldError)):
        raise error
    file, line = where if where[0] else definition(defined, _top(defined))
    raise UserCodeError(file, line, error_reason(error), environment_id) from error


def _line_in(defined: Any, error: Exception) -> tuple[str, int]:
    return error_line(error, _files_of(_top(defined), definition(defined)[0]).__contains__)


def _top(defined: Any) -> str:
    """Name of the top-level package in which something is defined."""
    return str(getattr(defined, "__module__", "")).partition(".")[0]


def _files_of(top: str, file: str) -> set[str]:
    """A file, and the loaded files of a top-level package that is not this one."""
    if top == "prp_gym":
        return set()
    loaded = (entry for name, entry in list(sys.modules.items()) if f"{name}.".startswith(f"{top}."))
    return {file, *(str(getattr(entry, "__file__", "")) for entry in loaded)} - {""}


def _load_file(path: Path, sha256: str) -> ModuleType:
    """A file as a module, executed once in a process."""
    name = f"user_file_{sha256[:16]}_{_sha256(bytes(path))[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    content = _read(path)
    if _sha256(content) != sha256:
        allowed = f"that of when the command began, {sha256}"
        raise InvalidValueError(f"SHA-256 of {path.name!r}", _sha256(content), allowed)
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        exec(compile(content, str(path), "exec"), vars(module))
    except Exception as error:
        del sys.modules[name]
        file, line = error_line(error, str(path).__eq__)
        raise UserCodeError(file or str(path), line or 1, error_reason(error)) from error
    return module


def _import(name: str) -> ModuleType:
    search_current_folder()
    try:
        return import_module(name)
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and error.name and f"{name}.".startswith(f"{error.name}."):
            allowed = f"{_FORMS}; there is no module {error.name!r}, neither installed nor in this folder"
            raise InvalidValueError("controller", name, allowed) from None
        file, line = error_line(error, lambda file: not file.startswith("<") and "importlib" not in file)
        raise UserCodeError(file or name, line, error_reason(error)) from error


def _shown(module: ModuleType, source: str) -> str:
    return str(module.__file__ or source)


def _read(path: Path) -> bytes:
    try:
        return FileReader(RECORD_SIZE).read_bytes(path)
    except DataFileError as error:
        allowed = f"a file that can be read ({error.what})"
        raise InvalidValueError("file of a controller", str(path), allowed) from error


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
