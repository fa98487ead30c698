"""The results of the last run of all clients, which the documentation shows."""

import json
from pathlib import Path

from bench.clients.client import Client
from bench.clients.environment import Outcome

RESULTS = Path(__file__).with_name("results.json")


def read_results() -> dict[str, Outcome]:
    """The stored outcomes by the names of the clients."""
    if not RESULTS.exists():
        return {}
    stored = json.loads(RESULTS.read_text(encoding="utf-8"))
    return {name: Outcome(**fields) for name, fields in stored.items()}


def verdict(client: Client, outcome: Outcome) -> str:
    """What the table says about a client."""
    if outcome.message:
        return outcome.message
    return f"unchanged; its own limit: {client.limit}" if client.limit else "unchanged"
