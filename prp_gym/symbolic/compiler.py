"""Compiling generated C code into a shared library, once for each text and compiler."""

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

FLAGS = (
    *("-O2", "-std=c11", "-fPIC", "-shared"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-builtin-pow"),
)
"""The compiler may change no result: products and sums are rounded one by one, as in NumPy, and a power of a
constant is that of the mathematical library."""

_SECONDS = 300.0


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


def compiles_by_default() -> bool:
    """Whether compiled code stands in for NumPy: with a compiler, unless `$PRP_GYM_COMPILED` is 0."""
    if os.environ.get("PRP_GYM_COMPILED") == "0":
        return False
    try:
        find_compiler()
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


@cache
def load_library(source: str) -> ctypes.CDLL:
    """The shared library of a C source, compiled unless it is in the cache.

    Raises:
        CompilerError: no compiler, or one that refuses the source.
    """
    command = find_compiler()
    machine = sys.platform, platform.machine()
    key = hashlib.sha256("\0".join((*command, *FLAGS, *machine, source)).encode()).hexdigest()[:32]
    path = cache_folder() / f"{key}.so"
    try:
        return ctypes.CDLL(str(path))
    except OSError:  # not there, damaged, or in a folder whose files may not be run
        return _compile(command, source, path)


def _compile(command: tuple[str, ...], source: str, path: Path) -> ctypes.CDLL:
    """Compile, load, and put the library into the cache where there is one."""
    with tempfile.TemporaryDirectory(prefix="prp_gym-", ignore_cleanup_errors=True) as folder:
        text, built = Path(folder) / "generated.c", Path(folder) / "built.so"
        text.write_text(source, encoding="utf-8")
        _run([*command, *FLAGS, "-o", str(built), str(text), "-lm"])
        library = ctypes.CDLL(str(built))
        with contextlib.suppress(OSError):  # a cache that cannot be used
            _keep(built, path)
    return library


def _keep(built: Path, path: Path) -> None:
    """Copy a library into the cache, where it appears when it is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, unfinished = tempfile.mkstemp(dir=path.parent)
    os.close(descriptor)
    try:
        shutil.copyfile(built, unfinished)
        os.replace(unfinished, path)
    finally:
        Path(unfinished).unlink(missing_ok=True)


def _run(command: list[str]) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_SECONDS, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise _failure(f"{command[0]} could not run: {error}") from error
    if done.returncode != 0:
        raise _failure(f"{command[0]} refused the generated code: {done.stderr[-500:]}")
