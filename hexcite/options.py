"""Options of programs, runs, the demo and studies, each declared once; nothing heavy is imported.

Arguments of `hx.write`, `hx.check`, `hx.run`, `hx.demo` and `hx.study`, and options of `hexcite post`, `check`, `run`,
`demo` and `study` are made from what stands here.
"""

from collections.abc import Collection
from pathlib import Path
from typing import Annotated

from cases.base.options import Option

Language = Annotated[
    str | None,
    Option(
        "The controller's language; by default the one that the suffix of the program's file names, else that of the "
        "controller that the plan was made for, else the first that the case can."
    ),
]
LanguageOfFile = Annotated[str | None, Option("The program's language; by default the one that its suffix names.")]
Speed = Annotated[float, Option("Share of the planned speed; 0.1 for a first try.", 1.0)]
Accept = Annotated[
    Collection[str] | str,
    Option(
        "A limit that the controller does not enforce and that you answer for, such as jerk; plans of the default "
        "need none.",
        (),
        written="Repeatable.",
        read_as=list[str],
    ),
]
Ini = Annotated[
    Path | str | None,
    Option(
        "LinuxCNC's INI file of the machine: refuse it where its planner or limits are others than the case's.",
        read_as=Path,
    ),
]
Controller = Annotated[str, Option("Controller: virtual or linuxcnc.", "virtual")]
NoiseSeed = Annotated[int, Option("Seed of the simulated sensors' noise.", 0)]
Weights = Annotated[int, Option("How many of the case's weights are mounted on the machine.", 0)]
Disturbed = Annotated[
    bool, Option("With the case's disturbances: vibration, ripple, errors that depend on the pose.", False)
]
DemoController = Annotated[
    str | None,
    Option(
        "Controller: virtual, which keeps all limits, or linuxcnc, which cannot keep jerk; by default virtual, with "
        "the first program of the case that keeps all limits."
    ),
]
DemoSeed = Annotated[int, Option("Seed of the starts and of the sensors' noise.", 0)]
DemoStarts = Annotated[int, Option("Number of random starts; one is enough for a demo.", 1)]
Scheduler = Annotated[str | None, Option("Running Dask scheduler, tls://host:port; by default this computer's cores.")]
Certificates = Annotated[
    Path | str | None,
    Option("Folder with ca.pem, cert.pem, key.pem for it; by default those of Dask's configuration.", read_as=Path),
]
Insecure = Annotated[bool, Option("Use a scheduler without TLS, tcp://host:port.", False)]
OneProcess = Annotated[
    bool,
    Option(
        "Compute here, one cell after the other: nothing listens on a port, Dask is not needed, and no limit of a "
        "cell's time and memory holds.",
        False,
    ),
]
