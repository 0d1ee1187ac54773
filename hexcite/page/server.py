"""The page's server: routes, each a reading of folders or the start of a command."""

import asyncio
import hashlib
import json
import socket
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, nullcontext, suppress
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Route

from cases.base.errors import Code, HexciteError, Interrupted, option
from cases.base.leftovers import ABANDONED, tidy
from hexcite.page import views
from hexcite.page.actions.common import Context
from hexcite.page.arrivals import WAIT, Runs, TooLarge, left_over, received
from hexcite.page.forms import field
from hexcite.page.jobs import CHECK, SETTINGS, Job, Jobs
from hexcite.page.journal import Address, keep_address
from hexcite.page.refusals import NoRecording, Refusal, RefusedFields
from hexcite.page.security import MOST_UPLOAD, PICTURE, REPORT, Guard, Outside, file_name, form_of, inside
from hexcite.page.stages import BAG_INDEX, PROGRAMS, RECORDINGS, STAGES, machine_of
from hexcite.page.words import CONTROLS, Words
from hexcite.texts import LANGUAGES, Language, language_of, text
from hexcite.texts.decimals import page_with_commas

MOST_REPORT = 2**26  # bytes of a report that is translated: ours have 2 MB
STATIC = {"page.css": "text/css", "page.js": "text/javascript"}
POLITE = 0.02  # [s] between looks at whether a page is being answered
UNASKED = 0.2  # [s] without a page being asked for, while a browser starts, after which stages are prepared
EVERY = 2.0  # [s] after which a stream shows the clock again
DOWNLOADS = (
    RECORDINGS
    | PROGRAMS
    | {".json", ".comp", ".st", ".c", ".h", ".dat", ".mod", ".py", ".txt", ".xml", ".toml", ".pdf", ".html"}
)


def app_of(
    root: Path, hosts: frozenset[str], token: str, cookie: str = "hexcite", cores: int | None = None
) -> Starlette:
    """The page as an ASGI application.

    Args:
        root: folder that it reads and writes, and none above it.
        hosts: addresses with ports that it answers to.
        token: secret of its address.
        cookie: name of the cookie that keeps it.
        cores: commands at once at most; by default one a core.
    """
    root = root.resolve()
    page = _Page(root)

    @asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        page.jobs = Jobs(root, cores)
        tasks = [
            asyncio.create_task(page.warmed()),
            asyncio.create_task(_tidied(root)),
            asyncio.create_task(page.given_up()),
        ]
        yield
        for task in tasks:
            task.cancel()
        await page.jobs.close()
        page.runs.close()

    routes = [
        Route("/", page.machines),
        Route("/new", page.new, methods=["POST"]),
        Route("/language", page.switch, methods=["POST"]),
        Route("/space", page.space),
        Route("/urdf/{name}", page.urdf),
        Route("/m/{key}/motion/{plan}", page.motion),
        Route("/upload/{name}", page.upload, methods=["PUT"]),
        Route("/runs", page.begin_run, methods=["POST"]),
        Route("/runs/{name}", page.end_run, methods=["POST"]),
        Route("/m/{key}", page.machine),
        Route("/m/{key}/{stage}", page.stage),
        Route("/m/{key}/do/{action}", page.act, methods=["POST"]),
        Route("/m/{key}/do/{action}", page.machine),  # the address of a refused form, asked for again
        Route("/jobs/{number:int}/events", page.events),
        Route("/jobs/{number:int}/stop", page.stop, methods=["POST"]),
        Route("/files/{path:path}", page.download),
        Route("/report/{folder}", page.report),
        Route("/picture/{name}", page.picture),
        Route("/sheet/{name}", page.sheet),
        Route("/static/{name}", page.static),
    ]
    errors: Any = {Outside: page.lost, HTTPException: page.lost, 404: page.lost, Refusal: page.unfit}
    guard = Middleware(Guard, hosts=hosts, token=token, cookie=cookie)
    return Starlette(routes=routes, middleware=[guard], exception_handlers=errors, lifespan=life)


async def _tidied(root: Path) -> None:
    """Clears the folder of what an earlier server, its commands or a browser left half finished; once more later."""
    for wait in (0.0, ABANDONED + 1.0):
        await asyncio.sleep(wait)
        names = await run_in_threadpool(_tidy, root)
        for name in names:
            print(f"{name}: from a command or upload that had ended before its time", file=sys.stderr, flush=True)


def _tidy(root: Path) -> list[str]:
    restored: list[Path] = []
    for folder in (root, *(each for each in root.iterdir() if not each.name.startswith("."))):
        if folder.is_dir() and not folder.is_symlink():
            with suppress(OSError):
                restored += tidy(folder)
    return [*(path.relative_to(root).as_posix() for path in restored), *left_over(root)]


_LAST = object()


class _Page:
    def __init__(self, root: Path) -> None:
        self.root = root
        self.answering = 0  # pages that are being answered
        self.runs = Runs(root)
        self.jobs: Jobs
        self.answered = asyncio.Event()  # once a page was sent
        self.templates = Environment(
            loader=PackageLoader(__package__, "templates"),
            autoescape=True,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        content = {name: (resources.files(__package__) / "templates" / name).read_bytes() for name in STATIC}
        self.static_files = {name: (data, hashlib.sha256(data).hexdigest()[:12]) for name, data in content.items()}
        self.templates.globals["version"] = {name: version for name, (_, version) in self.static_files.items()}
        self.templates.filters["control"] = lambda name: CONTROLS.get(name, name)
        self.templates.filters["quoted"] = lambda name: quote(str(name), safe="")

    async def warmed(self) -> None:
        """Imports what stages need: once a first page is out, with which it does not share the processor, or while the
        browser starts."""
        with suppress(TimeoutError):
            async with asyncio.timeout(UNASKED):
                await self.answered.wait()
        steps = views.warm_up()
        while await run_in_threadpool(next, steps, _LAST) is not _LAST:
            while self.answering:  # what someone waits for has the processor alone
                await asyncio.sleep(POLITE)

    async def given_up(self) -> None:
        """Shows, while the server goes on, what came of runs whose browser went away."""
        while True:
            await asyncio.sleep(WAIT / 10.0)
            for name in self.runs.give_up(self.jobs.outputs):
                print(f"{name}: its browser went away before all files had come", file=sys.stderr, flush=True)

    def _language(self, request: Request) -> Language:
        cookie = request.cookies.get("hexcite-language")
        return next(
            (each for each in LANGUAGES if each == cookie), language_of(request.headers.get("accept-language", ""))
        )

    def _rendered(self, request: Request, template: str, **values: Any) -> str:
        language = self._language(request)

        def say(key: str, **places: object) -> str:
            return text(key, language, **places)

        self.answered.set()
        always = {"t": say, "w": Words(language), "language": language, "root": str(self.root)}
        page = self.templates.get_template(template).render(**always, **values)
        return page_with_commas(page) if language == "de" else page

    def _context(self, request: Request) -> Context:
        machine = machine_of(self.root, request.path_params["key"])
        if machine is None:
            raise HTTPException(404)
        return Context(self.root, machine, self.jobs, Words(self._language(request)))

    async def machines(self, request: Request) -> Response:
        """The first stage without a machine: which one?"""
        values = await run_in_threadpool(views.machines, self.root)
        jobs = self.jobs.of("", "machine")
        return HTMLResponse(self._rendered(request, "machines.html.jinja", jobs=self._panels(request, jobs), **values))

    async def machine(self, request: Request) -> Response:
        """A machine by its address alone."""
        return RedirectResponse(f"/m/{quote(request.path_params['key'], safe='+')}/machine", 303)

    async def stage(self, request: Request) -> Response:
        """One stage of a machine."""
        context, stage = self._context(request), request.path_params["stage"]
        if stage not in STAGES:
            raise HTTPException(404)
        return await self._stage(request, context, stage)

    async def _stage(self, request: Request, context: Context, stage: str, status: int = 200, **more: Any) -> Response:
        changed = context.machine.file.stat().st_mtime
        jobs = self._panels(request, self.jobs.of(context.machine.key, stage), changed)
        query = dict(request.query_params)
        language = self._language(request)
        self.answering += 1
        try:
            values = await run_in_threadpool(views.stage, context, stage, query, language)
        finally:
            self.answering -= 1
        sentences = request.query_params.getlist("said")
        whole = {"jobs": jobs, "error": "", "saved": False, "said": sentences, **values, **more}
        return HTMLResponse(self._rendered(request, f"{stage}.html.jinja", stage=stage, **whole), status)

    async def act(self, request: Request) -> Response:
        """Starts what a form asks for, or writes a value."""
        from hexcite.page.actions.stated import state
        from hexcite.page.actions.table import ACTIONS, asked

        context, name = self._context(request), request.path_params["action"]
        fields = await form_of(request)
        if name == "preview":
            return await self._preview(request, context, fields)
        if name == "save":
            return await self._save(request, context, fields)
        if name == "state":
            address = await run_in_threadpool(state, context, fields)
            return RedirectResponse(address, 303)
        action = ACTIONS.get(name)
        if action is None:
            raise HTTPException(404)
        try:
            job = await run_in_threadpool(asked, action, context, fields)
        except NoRecording as error:
            return RedirectResponse(f"{context.address}/data?program={quote(error.name)}", 303)
        self.jobs.start(job)
        return RedirectResponse(f"/m/{quote(context.machine.key, safe='+')}/{job.stage}{job.query}#jobs", 303)

    async def _preview(self, request: Request, context: Context, fields: Any) -> Response:
        from hexcite.page.views.machine import preview

        values = await run_in_threadpool(preview, context, fields)
        return HTMLResponse(self._rendered(request, "drawing.html.jinja", **values))

    async def _save(self, request: Request, context: Context, fields: Any) -> Response:
        from markupsafe import Markup

        from hexcite.page.actions.machine import given_values, save

        saved = await run_in_threadpool(save, context, fields)
        if saved.refused is None:
            sentences = "".join(f"&said={quote(sentence, safe='')}" for sentence in saved.converted[:20])
            return RedirectResponse(f"/m/{quote(context.machine.key, safe='+')}/machine?saved=1{sentences}", 303)
        refusal, values = saved.refused, given_values(fields)
        of_fields = (refusal.fields, refusal.others) if isinstance(refusal, RefusedFields) else ({}, (refusal,))
        refused, others = context.words.refused_fields(of_fields[0]), of_fields[1]
        error = Markup("; ").join(map(context.words.refused, others))
        return await self._stage(request, context, "machine", 409, error=error, given=values, refused=refused)

    async def space(self, request: Request) -> Response:
        """What draws a machine in 3-D, in an origin of its own; scenes are sent to it."""
        from hexcite.reports.page import space_page

        headers = {"content-security-policy": REPORT, "cache-control": "private, max-age=600"}
        return HTMLResponse(await run_in_threadpool(space_page), headers=headers)

    async def motion(self, request: Request) -> Response:
        """The machine along a plan, as a scene."""
        from hexcite.page.views.plan import scene as scene_of

        context, name = self._context(request), request.path_params["plan"]
        scene = await run_in_threadpool(scene_of, context, name)
        if scene is None:
            raise HTTPException(404)
        return Response(scene, media_type="application/json")

    async def urdf(self, request: Request) -> Response:
        """A robot's file: which link carries the sensor?"""
        file = inside(self.root, request.path_params["name"])
        if file.suffix.lower() != ".urdf" or not file.is_file():
            raise HTTPException(404)
        from hexcite.page.views.machine import urdf

        values = await run_in_threadpool(urdf, file)
        return HTMLResponse(self._rendered(request, "urdf.html.jinja", **values))

    async def new(self, request: Request) -> Response:
        """Begins a case of one's own."""
        from hexcite.page.actions.machine import new

        fields = await form_of(request)
        self.jobs.start(await run_in_threadpool(new, self.root, fields))
        return RedirectResponse("/#jobs", 303)

    async def switch(self, request: Request) -> Response:
        """Keeps the other language."""
        fields = await form_of(request)
        back = field(fields, "back", "/")
        answer = RedirectResponse(back if back.startswith("/") and not back.startswith(("//", "/\\")) else "/", 303)
        language = next((each for each in LANGUAGES if each == field(fields, "language")), "en")
        answer.set_cookie("hexcite-language", language, max_age=31_536_000, httponly=True, samesite="strict")
        return answer

    async def upload(self, request: Request) -> Response:
        """Takes a file as it comes, onto the disk, under a name that nothing has yet."""
        name, run = file_name(request.path_params["name"]), request.query_params.get("into")
        arriving = nullcontext(self.root) if run is None else self.runs.arriving(run)
        kinds = RECORDINGS | ({".urdf", ".pdf", ".ini"} if run is None else set())
        if Path(name).suffix.lower() not in kinds and not (run is not None and name == BAG_INDEX):
            return JSONResponse({"error": "suffix"}, 415)
        length = request.headers.get("content-length", "")
        if length.isdigit() and int(length) > MOST_UPLOAD:
            return JSONResponse({"error": "too_large"}, 413)
        try:
            with arriving as folder:
                placed = await received(self.root, folder, name, request.stream(), MOST_UPLOAD)
        except TooLarge:
            return JSONResponse({"error": "too_large"}, 413)
        except ClientDisconnect:
            return Response(status_code=400)
        return JSONResponse({"error": "name"}, 409) if placed is None else JSONResponse({"name": placed.name})

    async def begin_run(self, request: Request) -> Response:
        """Makes a folder that the files of one run come into; it appears when all of them are there."""
        return JSONResponse({"name": self.runs.begin()})

    async def end_run(self, request: Request) -> Response:
        """Gives the folder of a run its name, that which its files have in common."""
        name = self.runs.end(request.path_params["name"], self.jobs.outputs)
        return JSONResponse({"name": name}) if name else JSONResponse({"error": "name"}, 409)

    def _panels(self, request: Request, jobs: list[Job], changed: float = 0.0) -> list[dict[str, Any]]:
        """Panels of jobs as they are now: one that ends while its stage is drawn is not over there, whose answer is
        not either, and the browser goes on following it.

        Args:
            changed: when the case was, since the epoch [s]: what was refused before may be true no longer, and a check
                of other values is not shown.
        """
        outdated = {job for job in jobs if job.state == "done" and job.finished < changed}
        shown = [job for job in jobs if job not in outdated or job.about not in (CHECK, SETTINGS)]
        return [{"job": job, "over": job.over, "html": self._panel(request, job, changed)} for job in shown]

    def _panel(self, request: Request, job: Job, changed: float = 0.0) -> Any:
        from markupsafe import Markup

        values = views.job(job, self._language(request))
        old = job.state == "failed" and job.finished < changed
        return Markup(self._rendered(request, "job.html.jinja", job=job, old=old, **values))

    def _job(self, request: Request) -> Job:
        job = self.jobs.get(request.path_params["number"])
        if job is None:
            raise HTTPException(404)
        return job

    async def events(self, request: Request) -> Response:
        """The panel of a job whenever it has changed, as server-sent events; the last one says where to go."""
        job = self._job(request)

        async def stream() -> AsyncIterator[str]:
            while True:
                changed = job.changed
                yield _event("panel", json.dumps(self._panel(request, job)))
                if job.over:
                    yield _event("over", json.dumps(job.goto if job.arrived else ""))
                    return
                with suppress(TimeoutError):
                    async with asyncio.timeout(EVERY):
                        await changed.wait()

        return StreamingResponse(stream(), media_type="text/event-stream")

    async def stop(self, request: Request) -> Response:
        """Ends a job; a search keeps its best motion."""
        job = self._job(request)
        self.jobs.stop(job)
        address = f"/m/{quote(job.machine, safe='+')}/{job.stage}" if job.machine else "/"
        return RedirectResponse(f"{address}#jobs", 303)

    async def download(self, request: Request) -> Response:
        """A file of the root folder, or of a folder in it, to be kept by the browser."""
        path = inside(self.root, *request.path_params["path"].split("/")[:4])
        if not path.is_file() or path.suffix.lower() not in DOWNLOADS:
            raise HTTPException(404)
        return FileResponse(path, media_type="application/octet-stream", filename=path.name)

    async def report(self, request: Request) -> Response:
        """The report of a plan or result, in an origin of its own."""
        return await self._framed(request, inside(self.root, request.path_params["folder"], "report.html"))

    async def sheet(self, request: Request) -> Response:
        """A page that a command wrote beside its table, in an origin of its own."""
        path = inside(self.root, request.path_params["name"])
        if path.suffix != ".html":
            raise HTTPException(404)
        return await self._framed(request, path)

    async def _framed(self, request: Request, path: Path) -> Response:
        """A page that a command wrote, in the language of this one."""
        if self._language(request) == "en" or not path.is_file() or path.stat().st_size > MOST_REPORT:
            return await self._shown(path, "text/html", REPORT)
        from hexcite.reports.translated import in_german

        page = await run_in_threadpool(lambda: in_german(path.read_text(encoding="utf-8")))
        return HTMLResponse(page, headers={"content-security-policy": REPORT})

    async def picture(self, request: Request) -> Response:
        """A picture that a command drew."""
        path = inside(self.root, request.path_params["name"])
        if path.suffix != ".svg":
            raise HTTPException(404)
        if self._language(request) == "en" or not path.is_file() or path.stat().st_size > MOST_REPORT:
            return await self._shown(path, "image/svg+xml", PICTURE)
        from hexcite.reports.translated import picture_in_german

        svg = await run_in_threadpool(lambda: picture_in_german(path.read_text(encoding="utf-8")))
        return Response(svg, media_type="image/svg+xml", headers={"content-security-policy": PICTURE})

    async def _shown(self, path: Path, kind: str, policy: str) -> Response:
        if not path.is_file():
            raise HTTPException(404)
        return FileResponse(path, media_type=kind, headers={"content-security-policy": policy})

    async def static(self, request: Request) -> Response:
        """The style sheet and the script."""
        name = request.path_params["name"]
        if name not in STATIC:
            raise HTTPException(404)
        content, version = self.static_files[name]
        asked = request.query_params.get("v") == version
        caching = "private, max-age=31536000, immutable" if asked else "no-cache"
        return Response(content, media_type=STATIC[name], headers={"cache-control": caching})

    async def lost(self, request: Request, error: Exception) -> Response:
        """A place that there is not, or that a browser may not name."""
        status = error.status_code if isinstance(error, HTTPException) else 404
        return HTMLResponse(self._rendered(request, "lost.html.jinja", message=""), status)

    async def unfit(self, request: Request, error: Exception) -> Response:
        """A form with a field that cannot be used."""
        message = Words(self._language(request)).refused(error) if isinstance(error, Refusal) else ""
        return HTMLResponse(self._rendered(request, "lost.html.jinja", message=message), 400)


def _event(kind: str, data: str) -> str:
    return f"event: {kind}\ndata: {data}\n\n"


def _bound(host: str, port: int, wanted: int) -> socket.socket:
    """A socket at a port; where that is 0, at the wanted one if it is free. Raises OSError."""
    ports = (wanted, 0) if port == 0 and wanted else (port,)
    for each in ports:
        listener = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, each))
            return listener
        except OSError:
            listener.close()
            if each == ports[-1]:
                raise
    raise AssertionError


def serve(root: Path, host: str, port: int, address: Address, opened: Callable[[str], None]) -> None:
    """Serves the page until Ctrl-C; `opened` is called with its address once it answers.

    Args:
        port: 0 for that of `address`, or any that is free.
        address: that the page of the folder had before, whose secret it has again.
    """
    import uvicorn

    token = address.token
    try:
        listener = _bound(host, port, address.port)
    except OSError as error:
        what = f"cannot be served at ({error.strerror})"
        raise HexciteError(
            place=f"{host}:{port}",
            problem=what,
            remedy=f"choose another {option('port')}, or leave it out",
            code=Code.NOT_WRITABLE,
        ) from error
    port = listener.getsockname()[1]
    host_in_address = f"[{host}]" if ":" in host else host
    if host == "127.0.0.1":
        keep_address(root, Address(port, token))
    names = {f"{host_in_address}:{port}"} | ({f"localhost:{port}"} if host in ("127.0.0.1", "::1") else set())
    app = app_of(root, frozenset(names), token, f"hexcite-{port}")
    server = uvicorn.Server(uvicorn.Config(app, log_level="warning", access_log=False, timeout_graceful_shutdown=3))

    async def run() -> None:
        task = asyncio.create_task(server.serve([listener]))
        while not server.started and not task.done():
            await asyncio.sleep(0.02)
        if server.started:
            opened(f"http://{host_in_address}:{port}/?token={token}")
        await task

    with suppress(KeyboardInterrupt, Interrupted):  # which uvicorn passes on once it has ended
        asyncio.run(run())
