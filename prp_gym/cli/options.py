"""Options that several commands have."""

from typing import Annotated

import typer

Environments = Annotated[list[str] | None, typer.Option(help="Environment id; repeatable. Default: all.")]
Controllers = Annotated[list[str] | None, typer.Option(help="Law; repeatable. Default: all.")]
FirstSeed = Annotated[int, typer.Option(help="Seed of the first episode.")]
ParallelWorkers = Annotated[
    int,
    typer.Option(
        help="Pairs at once; 1: in this process, 0: as many as there are cores. "
        "Compute times are those of a busy machine unless 1."
    ),
]
Backend = Annotated[
    str, typer.Option(help="loky: processes; ray: the cluster at RAY_ADDRESS, or a local one.")
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Play also what an interrupted run has finished.")]
