"""Commands of hexcite in processes of their own, with progress: as many at once as there are cores; each can be ended.

A process ends with the server, as after Ctrl-C: a search then keeps its best motion.
"""

import asyncio
import json
import os
import shlex
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from hexcite.page.journal import Journal, alive

State = Literal["waiting", "running", "stopping", "done", "failed", "stopped", "killed"]
_OVER: tuple[State, ...] = ("done", "failed", "stopped", "killed")
CHECK, SETTINGS = "check", "settings"  # what jobs are about that say nothing once the case has changed
MOST_LINE = 2**20  # bytes of a line of stderr
MOST_KEPT = 50  # jobs that have ended
PATIENCE = 20.0  # [s] that a search has to write its best motion when the server ends


@dataclass(eq=False)
class Job:
    """One command, under way or ended.

    Args:
        machine: key of the machine; empty where there is none yet.
        stage: name of the stage that shows it; empty of one that runs beside another.
        command: what follows `hexcite` on a command line.
        output: file or folder that it writes, relative to the root; empty where it writes none.
        about: what it was started for, such as a recording.
        query: of the stage's address while it is under way.
        goto: address to show when it is done.
        search: whether an interrupt keeps the best motion until then.
        before: command line of what was done before it started, in one with it.
        notes: what was written then.
        writes: whether it writes the case: what is started for the machine after it waits until it has ended.
        beside: jobs that start with it, and whose panels nobody needs.
        number: of this server.
        name: of its record.
        refused: the error that it was refused with, as entries for programs; empty where it was not.
    """

    machine: str
    stage: str
    command: tuple[str, ...]
    output: str = ""
    about: str = ""
    query: str = ""
    goto: str = ""
    search: bool = False
    before: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    writes: bool = False
    beside: tuple["Job", ...] = ()
    number: int = 0
    name: str = ""
    state: State = "waiting"
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None
    finished: float = 0.0  # time of the day [s]
    progress: list[dict[str, Any]] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    answer: dict[str, Any] | None = None
    refused: Mapping[str, Any] = field(default_factory=dict)
    process: asyncio.subprocess.Process | None = None
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self.state in _OVER

    @property
    def arrived(self) -> bool:
        """Whether what it was started for is there: also where limits that it judges by are exceeded, exit code 1."""
        judged = self.answer is not None and ("accept" in self.answer or "reference" in self.answer)
        return self.state == "done" or (self.state == "failed" and judged)

    @property
    def seconds(self) -> float:
        """How long it took, or takes until now."""
        return (time.monotonic() if self.ended is None else self.ended) - self.began

    @property
    def shown(self) -> str:
        """The command line that does the same in a terminal."""
        lines = [self.before, self.command] if self.before else [self.command]
        return "\n".join(shlex.join(("hexcite", *line)) for line in lines)

    @property
    def record(self) -> dict[str, Any]:
        """What a later server has to know of it."""
        return {
            "server": os.getpid(), "number": self.number, "machine": self.machine, "stage": self.stage,
            "command": self.command, "output": self.output, "about": self.about, "query": self.query,
            "goto": self.goto, "search": self.search, "before": self.before, "notes": self.notes, "state": self.state,
            "seconds": self.seconds, "finished": self.finished, "progress": self.progress, "messages": self.messages,
            "answer": self.answer, "refused": self.refused,
        }  # fmt: skip

    @classmethod
    def of_record(cls, name: str, kept: Mapping[str, Any]) -> "Job":
        """A job of an earlier server; one that had not ended was killed with it. Raises KeyError, TypeError."""
        state: State = next((each for each in _OVER if each == kept["state"]), "killed")
        return cls(
            str(kept["machine"]), str(kept["stage"]), tuple(map(str, kept["command"])), output=str(kept["output"]),
            about=str(kept["about"]), query=str(kept["query"]), goto=str(kept["goto"]), search=bool(kept["search"]),
            before=tuple(map(str, kept["before"])), notes=tuple(map(str, kept["notes"])), number=int(kept["number"]),
            name=name, state=state, began=0.0, ended=float(kept["seconds"]), finished=float(kept["finished"]),
            progress=[each for each in kept["progress"] if isinstance(each, dict)],
            messages=list(map(str, kept["messages"])),
            answer=kept["answer"] if isinstance(kept["answer"], dict) else None,
            refused=kept["refused"] if isinstance(kept.get("refused"), dict) else {},
        )  # fmt: skip

    def tell(self) -> None:
        """Wakes those who watch it."""
        self.changed.set()
        self.changed = asyncio.Event()

    def interrupt(self) -> None:
        """Asks it to end as Ctrl-C does; a second time it is killed, with its own processes."""
        process = self.process
        if self.over or process is None:
            return
        with suppress(ProcessLookupError):
            if self.state == "stopping":
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.send_signal(signal.SIGINT)
        self.state = "stopping"
        self.tell()


class Jobs:
    """The jobs of a server, in one root folder."""

    def __init__(self, root: Path, cores: int | None = None) -> None:
        self.root = root
        self._room = asyncio.Semaphore(cores or os.cpu_count() or 1)
        self._all: dict[int, Job] = {}
        self._tasks: dict[int, asyncio.Task[None]] = {}
        self._next = 1
        self._journal = Journal(root)
        self._recall()

    def _recall(self) -> None:
        """Takes over what earlier servers of the folder kept; what another one has under way is its own."""
        for name, record in self._journal.records().items():
            with suppress(KeyError, TypeError, ValueError):
                job = Job.of_record(name, record)
                if record["state"] not in _OVER and alive(record["server"]):
                    continue
                job.number = job.number if job.number not in self._all else max(self._all) + 1
                if job.state == "killed" and job.output and (self.root / job.output).exists():
                    job.state = "done"
                self._all[job.number] = job
        self._next = max(self._all, default=0) + 1

    def start(self, job: Job) -> None:
        """Starts a command, at once or when there is room."""
        job.number, self._next = self._next, self._next + 1
        self._all[job.number] = job
        for old in [other for other in self._all.values() if other.over][:-MOST_KEPT]:
            del self._all[old.number]
            self._journal.remove(old.name)
        job.name = f"{time.time_ns()}-{os.getpid()}-{job.number}"
        self._journal.write(job.name, job.record)
        first = [
            self._tasks[other.number]
            for other in self._all.values()
            if other.writes and not other.over and other is not job and other.machine == job.machine
        ]
        self._tasks[job.number] = asyncio.create_task(self._run(job, first))
        for other in job.beside:
            self.start(other)

    def get(self, number: int) -> Job | None:
        """A job by its number."""
        return self._all.get(number)

    def of(self, machine: str, stage: str) -> list[Job]:
        """Jobs of a stage: all that are under way, and the latest that has ended."""
        jobs_of_stage = [job for job in self._all.values() if (job.machine, job.stage) == (machine, stage)]
        return [job for k, job in enumerate(jobs_of_stage) if not job.over or k == len(jobs_of_stage) - 1]

    def latest(self, machine: str, word: str, about: str) -> Job | None:
        """The latest job of a machine that ran a command of this name for something."""
        jobs_of_machine = [job for job in self._all.values() if (job.machine, job.about) == (machine, about)]
        return next((job for job in reversed(jobs_of_machine) if job.command[0] == word), None)

    def writing(self, output: str) -> Job | None:
        """The latest job that writes something of this name."""
        return next((job for job in reversed(self._all.values()) if job.output == output), None)

    @property
    def outputs(self) -> set[str]:
        """What jobs under way will write."""
        return {job.output for job in self._all.values() if not job.over and job.output}

    def stop(self, job: Job) -> None:
        """Ends a job; a search keeps its best motion until then."""
        if job.state == "waiting":
            self._tasks[job.number].cancel()
            self._end(job, "stopped")
        else:
            job.interrupt()

    async def close(self) -> None:
        """Ends all jobs: searches have some seconds to write their best motion."""
        tasks = [task for task in self._tasks.values() if not task.done()]
        for job in self._all.values():
            if not job.over:
                self.stop(job)
        if tasks:
            await asyncio.wait(tasks, timeout=PATIENCE)
        for job in self._all.values():
            if not job.over:
                job.state = "stopping"
                job.interrupt()

    def _end(self, job: Job, state: State) -> None:
        job.state, job.ended, job.finished, job.process = state, time.monotonic(), time.time(), None
        self._tasks.pop(job.number, None)
        self._journal.write(job.name, job.record)
        print(f"{job.shown}: {state}, {job.seconds:.0f} s", file=sys.stderr, flush=True)
        job.tell()

    async def _run(self, job: Job, first: list[asyncio.Task[None]]) -> None:
        if first:
            await asyncio.wait(first)
        async with self._room:
            job.began, job.state = time.monotonic(), "running"
            # -P: the root folder is the current one, and files in it are not modules
            arguments = [sys.executable, "-P", "-m", GUEST, str(os.getpid()), *job.command, "--json"]
            job.process = await asyncio.create_subprocess_exec(
                *arguments,
                cwd=self.root,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
                start_new_session=True,
                limit=MOST_LINE,
            )
            process = job.process
            job.tell()
            assert process.stdout is not None
            assert process.stderr is not None
            try:
                output, _, _ = await asyncio.gather(
                    process.stdout.read(), self._listen(job, process.stderr), _alone(process)
                )
                code = await process.wait()
            except BaseException:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                raise
            with suppress(ValueError):
                answer = json.loads(output)
                job.answer = None if answer.keys() == {"error"} else answer  # an error is among the messages
                job.refused = answer.get("error") or {}
            self._end(job, self._state(job, code))

    def _state(self, job: Job, code: int) -> State:
        """How a job has ended, by its exit code, the wish to stop it, and what it wrote."""
        ended_early = code == 130 or code < 0
        if code == 0 or (ended_early and job.output and (self.root / job.output).exists()):
            return "done"
        return "failed" if not ended_early else "stopped" if job.state == "stopping" else "killed"

    async def _listen(self, job: Job, stream: asyncio.StreamReader) -> None:
        """Takes progress and messages from a process."""
        while True:
            try:
                line = (await stream.readline()).decode("utf-8", "replace").strip()
            except ValueError:  # longer than a line may be
                continue
            if not line:
                if stream.at_eof():
                    return
                continue
            try:
                news = json.loads(line)
            except ValueError:
                news = None
            if isinstance(news, dict):
                job.progress.append({**news, "at": job.seconds})
            else:
                job.messages.append(line.removeprefix("hexcite: "))
            job.tell()


async def _alone(process: asyncio.subprocess.Process) -> None:
    """Ends what a process has started itself as soon as it has ended, however: its streams are open until then."""
    while process.returncode is None:
        await asyncio.sleep(LOOK)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


LOOK = 0.05  # [s] between two looks whether a process has ended
GUEST = "hexcite.cli.guest"
"""The module that runs one command, and ends with the server."""
