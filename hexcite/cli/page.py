"""`hexcite page`: the guided page in a browser."""

import secrets
import sys
from pathlib import Path
from typing import Annotated

import hexcite as hx
from cases.base.errors import Code
from hexcite.cli.console import argument, option

HOME = "127.0.0.1"


def page(
    folder: Annotated[Path, argument("Folder that the page reads and writes; the current one by default.")] = Path(),
    port: Annotated[int, option("Port; by default one that is free.")] = 0,
    host: Annotated[str, option("Address to serve at; others than 127.0.0.1 are open to the network.")] = HOME,
    browser: Annotated[bool, option("Open the browser.", "--browser/--no-browser")] = True,
) -> None:
    """Serve the guided page, from machine to result.

    Each stage runs commands of hexcite in FOLDER and shows them. Ctrl-C ends it; a search then keeps its best motion.
    """
    if not folder.is_dir():
        raise hx.HexciteError(
            place=folder, problem="is not a folder", remedy="make it, or name another one", code=Code.NOT_WRITABLE
        )
    if not 0 <= port <= 65535:
        raise hx.HexciteError(
            place=f"--port {port}",
            problem="is not a port",
            remedy="give 1 to 65535, or leave it out",
            code=Code.OUT_OF_RANGE,
        )
    if host in ("0.0.0.0", "::"):
        raise hx.HexciteError(
            place=f"--host {host}",
            problem="is every address of this computer",
            remedy="name one of them",
            code=Code.WRONG_KIND,
        )
    try:
        from hexcite.page.server import serve
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn"):
            raise
        raise hx.HexciteError(
            place=f"the page needs {error.name}",
            problem="install it: pip install starlette uvicorn",
            code=Code.NOT_INSTALLED,
        ) from error
    from hexcite.page.journal import Address, address_of

    root = folder.resolve()
    address = address_of(root) if host == HOME else Address(0, secrets.token_urlsafe(24))
    if host != HOME:
        print(
            f"hexcite: {host} is open to the network, without encryption: whoever has the address below can run "
            f"searches and write files in {root}",
            file=sys.stderr,
        )

    def opened(address: str) -> None:
        print(f"The page is at {address}\nIt works in {root}; Ctrl-C ends it.", flush=True)
        if browser:
            import webbrowser

            webbrowser.open(address)

    serve(root, host, port, address, opened)
