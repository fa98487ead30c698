"""The page of the commands with their options."""

from typing import Any

import typer

from docs.tables import NOTE, table
from prp_gym.cli.main import app

_COMMON = """An option means the same in every command that has it, and so does its short form. In short:

- `--resume`, the default, goes on with what an interrupted run of the same command has kept; `--fresh`
  starts over.
- `--output` is what the command writes: a folder, or a file where it writes one. Without it, every run
  has a folder of its own, `results/<command>/<date and time>`, and `results/<command>/latest` leads to the
  last one; see [publishing](publishing.md).
- `--jobs` are parallel workers, `--seed` is the random seed, `--episodes` are those of each policy.
- Standard output holds the results alone. Progress goes to standard error: bars in a terminal, elsewhere a
  line at least every 30 s. `--quiet` leaves it out, together with the notes below tables; `--json` prints the
  results as one JSON document in place of tables, and `--format` gives the tables another form.
- `prp-gym --install-completion` lets the shell complete commands, options and names.
- Ctrl-C ends a command with a message that says what was kept and how to go on.
"""


def command_line_page() -> str:
    """Every command with its options."""
    parts = [NOTE, "# Command line\n", _COMMON]
    group: Any = typer.main.get_command(app)
    for name, command in sorted(group.commands.items()):
        parts += [f"## prp-gym {name}\n", command.help or "", ""]
        rows = [
            (f"`{'`, `'.join((*p.opts, *p.secondary_opts))}`", _default(p), p.help or "")
            for p in command.params
            if p.opts != ["--help"]
        ]
        if rows:
            parts.append(table(("option", "default", "meaning"), rows))
    parts.append(
        "If a name does not exist, a command ends with a message that names the nearest one and lists the"
        " valid ones, and with exit code 2.\n"
    )
    return "\n".join(parts)


def _default(parameter: Any) -> str:
    """The default of an option: in words where it depends on the command, otherwise its value."""
    shown = getattr(parameter, "show_default", "")
    if parameter.required:
        return ""
    if parameter.default in (None, ""):
        return shown if isinstance(shown, str) else ""
    if isinstance(parameter.default, list):
        return ", ".join(f"`{item}`" for item in parameter.default)
    return f"`{parameter.default}`"
