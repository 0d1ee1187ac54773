"""hexcite in a notebook's kernel: what values look like, how often a search is heard of, and Ctrl-C in it."""

import asyncio
from typing import Any

import pytest
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell, new_notebook

CELLS = (
    "import time\nimport numpy as np\nimport hexcite as hx\nstamps = []\ncase = hx.load_case('hexapod')\ncase",
    "by_hand = hx.plan(case, hx.Manual())\nby_hand",
    "program = hx.write(by_hand, 'sinumerik')\nprogram",
    "recording = hx.run(program, case)\nrecording",
    "result = hx.identify(recording, case)\nresult",
    # The kernel interrupts this cell; what was found until then stays.
    "plan = hx.plan(case, hx.PointToPoint(moves=12), 6.0, seconds=300.0, workers=1,\n"
    "               progress=lambda line: stamps.append(time.monotonic()))\nplan",
    "print(min(np.diff(stamps)), len(stamps), plan.limits.kept, plan.interrupted)",
)
SEARCH = 5  # number of the cell that is interrupted
PATIENCE = 20.0  # [s] before it is


async def executed() -> list[Any]:
    """Outputs of each cell."""
    notebook = new_notebook(cells=[new_code_cell(text) for text in CELLS])
    client = NotebookClient(notebook, timeout=600, kernel_name="python3")

    async def interrupt() -> None:
        await asyncio.sleep(PATIENCE)
        manager: Any = client.km
        await manager.interrupt_kernel()

    async with client.async_setup_kernel():
        for number, cell in enumerate(notebook.cells):
            pressed = asyncio.create_task(interrupt()) if number == SEARCH else None
            await client.async_execute_cell(cell, number)
            if pressed is not None:
                await pressed
    return [cell.outputs for cell in notebook.cells]


@pytest.mark.slow
def test_a_kernel_shows_values_and_ends_a_search_by_ctrl_c(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONWARNINGS", "default")
    outputs = asyncio.run(executed())
    for number, word in enumerate(("hexapod", "limit", "limit", "Recording", "mass")):
        (value,) = (each for each in outputs[number] if each.output_type == "execute_result")
        assert word in value.data["text/html"]
        assert "text/plain" in value.data
    least, shown, kept, interrupted = outputs[-1][-1].text.split()
    assert float(least) >= 0.999
    assert 3 <= int(shown) <= PATIENCE + 60.0
    assert (kept, interrupted) == ("True", "True")
