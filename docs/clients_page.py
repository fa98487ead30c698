"""The page on other libraries: what each does with the environments, the program, the last result."""

from bench.clients.catalogue import CLIENTS
from bench.clients.client import Client
from bench.clients.environment import Outcome
from bench.clients.results import read_results, verdict
from docs.tables import NOTE, table

_HEADERS = ("library", "version", "Gymnasium", "result")

_INTRODUCTION = """# Use with other libraries

The environments are Gymnasium's, single (`gymnasium.make`) and together (`gymnasium.make_vec`), and libraries
that know Gymnasium use them as they are. `make clients` installs each library below in a virtual environment
of its own, runs its program there, and stores the results. "Unchanged" means that the program ran to its end
with the library as published. Stable-Baselines3 is not among them, since the suite trains with it; see
[learned agents](learning.md).

What the libraries rely on:

- Workers in other processes import the package if the id has its prefix: `prp_gym:PRP-Force-v0`.
- `env.spec.max_episode_steps` is the number of steps in an episode, whatever the `duration` and the control
  frequency.
- `reset` and `step` return the same numbers in `info`, as NumPy scalars.
- An unknown keyword raises an error that is also a `TypeError` in Python's words.
- Vector environments state when they reset themselves in `autoreset_mode`.

All of Gymnasium's wrappers, single and vector, run in the tests of the suite, except those for Atari games,
for environments in JAX, and for windows, which the render mode `human` opens without a wrapper.
"""


def clients_page() -> str:
    """Every library with its result, and the program that was run."""
    results = read_results()
    rows = [_row(client, results[client.name]) for client in CLIENTS if client.name in results]
    parts = [NOTE, _INTRODUCTION, table(_HEADERS, rows)]
    parts += [_section(client) for client in CLIENTS]
    return "\n".join(parts)


def _row(client: Client, outcome: Outcome) -> tuple[str, ...]:
    return client.title, client.version, outcome.gymnasium, verdict(client, outcome)


def _section(client: Client) -> str:
    text = client.program.read_text(encoding="utf-8")
    return f"## {client.title}\n\n{client.what[0].upper()}{client.what[1:]}.\n\n```python\n{text}```\n"
