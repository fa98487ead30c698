"""Shared libraries of generated C code: those of the package, those of the user's cache, or compiled now."""

import contextlib
import ctypes
import hashlib
import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from prp_gym.errors import CompilerError
from prp_gym.symbolic.diagnostics import FILE_NAME, find_rejection

FLAGS = (
    *("-O2", "-std=c11", "-fPIC", "-shared"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-builtin-pow"),
)
"""The compiler may change no result: products and sums are rounded one by one, as in NumPy, and a power of a
constant is that of the mathematical library."""

PREBUILT = Path(__file__).with_name("prebuilt")
"""The folder of libraries that a wheel for one kind of machine brings along; a source tree has none."""

_SECONDS = 300.0
_TRIAL = """#include <math.h>

void prp_trial(const double *restrict angle, double *restrict sine)
{
    for (int i = 0; i < 2; i++)
        sine[i] = sin(angle[i]);
}
"""  # what a compiler for C11 takes
_LOADED: list[str] = []


def _failure(reason: str) -> CompilerError:
    return CompilerError(f"compiled code needs a C compiler, and {reason}.")


@cache
def find_compiler() -> tuple[str, ...]:
    """The command of a C compiler: `$CC`, cc, gcc or clang, or that of the package ziglang.

    Raises:
        CompilerError: no compiler was found.
    """
    for command in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        name, *arguments = shlex.split(command) or [""]
        found = shutil.which(name) if name else None
        if found:
            return (found, *arguments)
    if importlib.util.find_spec("ziglang") is not None:
        return sys.executable, "-m", "ziglang", "cc"
    raise _failure("none was found: install gcc or clang, or: pip install ziglang")


def require_compiled_code() -> None:
    """Refuse a machine without compiled code.

    Raises:
        CompilerError: the package brings no libraries along, and no compiler was found, or one that does not
            work.
    """
    if any(PREBUILT.glob("*.so")):
        return
    fault = _fault(find_compiler())
    if fault:
        raise CompilerError(fault)


@cache
def _fault(command: tuple[str, ...]) -> str:
    """Why a compiler does not work; empty for one that does."""
    try:
        _own(_TRIAL, command)
    except CompilerError as error:
        return str(error)
    return ""


def is_turned_off() -> bool:
    """Whether `$PRP_GYM_COMPILED` is 0, so that compiled code does not stand in for NumPy."""
    return os.environ.get("PRP_GYM_COMPILED") == "0"


def compiles_by_default() -> bool:
    """Whether compiled code stands in for NumPy: where there is any, unless it was turned off."""
    if is_turned_off():
        return False
    try:
        require_compiled_code()
    except CompilerError:
        return False
    return True


def cache_folder() -> Path:
    """The folder of compiled libraries: `$PRP_GYM_CACHE`, or `prp_gym` in the user's folder of caches."""
    given = os.environ.get("PRP_GYM_CACHE")
    if given:
        return Path(given)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    if not os.path.isabs(base):  # a user without a home folder, in some containers
        base = tempfile.gettempdir()
    return Path(base) / "prp_gym"


def library_name(source: str, command: tuple[str, ...] = ()) -> str:
    """The file name of the library of a C source, on this kind of machine.

    Args:
        source: C source.
        command: command of the compiler; empty for a library of the package, whichever compiler made it.
    """
    machine = sys.platform, platform.machine()
    key = hashlib.sha256("\0".join((*command, *FLAGS, *machine, source)).encode()).hexdigest()[:32]
    return f"{key}.so"


@cache
def load_library(source: str) -> ctypes.CDLL:
    """The shared library of a C source: that of the package, else that of the cache, else compiled now.

    Raises:
        CompilerError: neither the package's library nor a compiler that works.
        GeneratedCodeError: a source that the compiler rejects.
    """
    library = _stored(PREBUILT / library_name(source)) or _own(source, find_compiler())
    _LOADED.append(source)
    return library


def loaded_sources() -> tuple[str, ...]:
    """The C sources whose libraries this process has loaded, each once."""
    return tuple(dict.fromkeys(_LOADED))


def build_library(source: str, folder: Path) -> Path:
    """Compile a C source for a wheel, without the symbols that only a debugger reads.

    Args:
        source: C source.
        folder: folder of the library, which exists.

    Returns:
        path of the library.

    Raises:
        CompilerError: no compiler, or one that does not work.
        GeneratedCodeError: a source that the compiler rejects.
    """
    path = folder / library_name(source)
    with tempfile.TemporaryDirectory(prefix="prp_gym-", ignore_cleanup_errors=True) as temporary:
        _keep(_compiled(find_compiler(), source, Path(temporary), "-s"), path)
    return path


def _stored(path: Path) -> ctypes.CDLL | None:
    """A library in a file; None where it cannot be loaded."""
    try:
        return ctypes.CDLL(str(path))
    except OSError:  # not there, damaged, of another C library, or in a folder whose files may not be run
        return None


def _own(source: str, command: tuple[str, ...]) -> ctypes.CDLL:
    """The library of this machine's compiler, which is put into the cache where there is one."""
    path = cache_folder() / library_name(source, command)
    stored = _stored(path)
    if stored is not None:
        return stored
    with tempfile.TemporaryDirectory(prefix="prp_gym-", ignore_cleanup_errors=True) as folder:
        built = _compiled(command, source, Path(folder))
        library = _stored(built)
        if library is None:
            raise _failure(f"what {command[0]} has compiled cannot be loaded")
        with contextlib.suppress(OSError):  # a cache that cannot be used
            _keep(built, path)
    return library


def _compiled(command: tuple[str, ...], source: str, folder: Path, *flags: str) -> Path:
    """The library of a source, in a folder for both."""
    built = folder / "built.so"
    messages = _compile(command, source, folder / FILE_NAME, built, *flags)
    if messages is None:
        return built
    rejection = find_rejection(command[0], source, messages)
    if rejection is not None and _compile(command, _TRIAL, folder / "trial.c", folder / "trial.so") is None:
        raise rejection
    raise _failure(f"{command[0]} failed: {messages[-500:]}")


def _compile(command: tuple[str, ...], source: str, text: Path, built: Path, *flags: str) -> str | None:
    """Compile a source by way of a file; what the compiler says where it fails, in English."""
    text.write_text(source, encoding="utf-8")
    done = _run([*command, *FLAGS, *flags, "-o", str(built), str(text), "-lm"])
    return None if done.returncode == 0 else done.stderr


def _keep(built: Path, path: Path) -> None:
    """Copy a library into a folder, where it appears when it is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, unfinished = tempfile.mkstemp(dir=path.parent)
    os.close(descriptor)
    try:
        shutil.copyfile(built, unfinished)
        os.replace(unfinished, path)
    finally:
        Path(unfinished).unlink(missing_ok=True)


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        return subprocess.run(
            command,
            capture_output=True,
            env=environment,
            encoding="utf-8",
            errors="replace",
            timeout=_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise _failure(f"{command[0]} could not run: {error}") from error
