"""A shell and a Python session in the environment that the README's own commands create, without downloads.

`git clone` links the tracked files, `make` checks that its targets exist and creates `.venv`, and `pip
install` makes the packages of an extra importable; until then they are hidden, as a bare installation lacks
them. All other commands run as they are.
"""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]

EXTRAS = {
    "agents": ("stable_baselines3", "sb3_contrib", "torch", "tensorboard", "yaml"),
    "tune": ("optuna",),
    "ray": ("ray",),
    "record": ("imageio_ffmpeg",),
    "video": ("moviepy",),
    "view": ("viser",),
}
"""Importable packages that an extra installs."""

_GIT = """#!/bin/sh
[ "$1" = clone ] || exec {git} "$@"
mkdir "$3" && {git} -C {root} ls-files | cut -d/ -f1 | sort -u | while read -r name; do
    ln -s "{root}/$name" "$3/$name"
done
"""

_MAKE = """#!/bin/sh
{make} --dry-run --always-make --directory {root} "$@" > /dev/null || exit
[ -e .venv ] || cp -a {venv} .venv
sed -i 's|^VIRTUAL_ENV=.*|VIRTUAL_ENV="'$PWD'/.venv"|' .venv/bin/activate
"""

_PIP = """#!/bin/sh
[ "$1" = install ] || exit 2
here=$(dirname "$0")
for argument in "$@"; do
    case "$argument" in
        *\\[*\\]*) echo "$argument" | sed 's/.*\\[//; s/\\].*//; s/,/\\n/g' >> "$here/../extras" ;;
    esac
done
"""

_COMMAND = """#!{python}
import sys
from prp_gym.cli.main import main
sys.argv[0] = "prp-gym"
main()
"""

_CUSTOMIZE = """
import json, site, sys
from pathlib import Path

sys.path.insert(0, {root!r})
site.addsitedir({packages!r})


class Hidden:
    packages = json.loads({extras!r})
    installed = Path(sys.prefix) / "extras"

    def find_spec(self, name, path=None, target=None):
        extras = self.installed.read_text().split() if self.installed.exists() else []
        for extra, packages in self.packages.items():
            if name.partition(".")[0] in packages and extra not in extras:
                raise ModuleNotFoundError(f"{{name}}: extra {{extra}} is not installed", name=name)


sys.meta_path.insert(0, Hidden())
"""

_SESSION = """
import json, sys, traceback
namespace = {"__name__": "__main__"}
for line in sys.stdin:
    try:
        exec(compile(json.loads(line), "README.md", "exec"), namespace)
        answer = ""
    except BaseException:
        answer = traceback.format_exc()
    print("\\n" + json.dumps(answer), flush=True)
"""


class ReadmeShell:
    """Runs blocks of the README one after the other, each where the last one ended.

    Args:
        folder: empty folder in which the shell starts.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        commands = folder / "commands"
        commands.mkdir()
        self._environment = {"PATH": f"{commands}:/usr/local/bin:/usr/bin:/bin", "HOME": str(folder)}
        self._working_folder = folder / "work"
        self._working_folder.mkdir()
        self._python: subprocess.Popen[str] | None = None
        self._make_environment(folder / "venv")
        names = {name: shutil.which(name, path="/usr/local/bin:/usr/bin:/bin") for name in ("git", "make")}
        _write(commands / "git", _GIT.format(git=names["git"], root=ROOT))
        _write(commands / "make", _MAKE.format(make=names["make"], root=ROOT, venv=folder / "venv"))

    def run(self, block: str) -> None:
        """Run a shell block; what it changes in environment and working folder holds for the next ones."""
        after = self._folder / "after.json"
        tell = f"import json, os; json.dump([dict(os.environ), os.getcwd()], open({str(after)!r}, 'w'))"
        script = f"set -e\n{block}\n{sys.executable} -c {json.dumps(tell)}\n"
        done = subprocess.run(
            ["/bin/bash", "-c", script],
            env=self._environment,
            cwd=self._working_folder,
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise RuntimeError(
                f"{block}\nended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-3000:]}"
            )
        self._environment, folder = json.loads(after.read_text())
        self._working_folder = Path(folder)

    def run_python(self, block: str) -> None:
        """Run a Python block in the namespace of the earlier ones, by the `python` that the shell finds."""
        if self._python is None:
            python = shutil.which("python", path=self._environment["PATH"])
            if python is None:
                raise RuntimeError("no python on the path")
            self._python = subprocess.Popen(
                [python, "-W", "error::DeprecationWarning:__main__", "-c", _SESSION],
                env=self._environment,
                cwd=self._working_folder,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        stdin: Any = self._python.stdin
        stdout: Any = self._python.stdout
        stdin.write(json.dumps(block) + "\n")
        stdin.flush()
        failure = ""
        for line in stdout:
            if line.startswith('"'):
                failure = json.loads(line)
                break
        else:
            failure = "the Python session ended"
        if failure:
            raise RuntimeError(f"{block}\n{failure}")

    def write(self, name: str, text: str) -> None:
        """Put a file into the working folder."""
        (self._working_folder / name).write_text(text, encoding="utf-8")

    def close(self) -> None:
        """End the Python session."""
        if self._python is not None:
            self._python.communicate()

    def _make_environment(self, folder: Path) -> None:
        """What `make install` creates: the package in editable form and its dependencies, without extras."""
        venv.EnvBuilder(symlinks=True).create(folder)
        packages = next((folder / "lib").glob("python*/site-packages"))
        customize = _CUSTOMIZE.format(
            root=str(ROOT), packages=sysconfig.get_path("purelib"), extras=json.dumps(EXTRAS)
        )
        (packages / "sitecustomize.py").write_text(customize, encoding="utf-8")
        _write(folder / "bin" / "pip", _PIP)
        _write(folder / "bin" / "prp-gym", _COMMAND.format(python="/usr/bin/env python"))


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
    os.chmod(path, 0o755)
