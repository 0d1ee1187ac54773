"""Programs as long as a controller's memory allows, read back and proven: seconds and memory."""

import resource
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from cases.controller import SinumerikAxes
from cases.schema import load_case
from postprocessors.program import read_program
from postprocessors.proof.proof import prove_program
from tests.postprocessors.other_dialects import SINUMERIK
from tests.postprocessors.programs import timed, typed

BLOCKS = 100_000


def dense_lines(blocks: int) -> str:
    """A LinuxCNC program of timed G1 blocks of 10 ms: two sines that swell and fade."""
    t = np.arange(1, blocks + 1) * 0.01
    swell = np.sin(np.pi * t / t[-1]) ** 2
    x, a = 20 * np.sin(2 * np.pi * t / 5) * swell, 2 * np.sin(2 * np.pi * t / 3.7) * swell
    lines = [f"G1 X{u:.5f} Y{u / 3:.5f} A{w:.6f} B{w / 2:.6f} F6000" for u, w in zip(x, a, strict=True)]
    return typed(f"M64 P0\n{timed(lines)}\nM65 P0")


def polynomials(blocks: int) -> str:
    """A SINUMERIK program of POLY blocks of 20 ms: the cubics that share values and rates with the same two sines."""
    t = np.arange(blocks + 1) * 0.02
    swell, change = np.sin(np.pi * t / t[-1]) ** 2, np.pi / t[-1] * np.sin(2 * np.pi * t / t[-1])
    end, second, third = [], [], []
    for size, turning in ((20.0, 2 * np.pi / 5), (2.0, 2 * np.pi / 3.7)):
        wave = size * np.sin(turning * t)
        value, step = wave * swell, 0.02 * (turning * size * np.cos(turning * t) * swell + wave * change)
        way = np.diff(value)
        end.append(value[1:])
        second.append(3 * way - 2 * step[:-1] - step[1:])
        third.append(step[:-1] + step[1:] - 2 * way)

    def word(axis: str, k: int, wave: int, share: float) -> str:
        return f"PO[{axis}]=({','.join(f'{share * part[wave][k]:.7f}' for part in (end, second, third))})"

    axes = (("X", 0, 1.0), ("Y", 0, 1 / 3), ("A", 1, 1.0), ("B", 1, 0.5))
    lines = [f"POLY {' '.join(word(axis, k, wave, share) for axis, wave, share in axes)} F3000" for k in range(blocks)]
    path = "\n".join(["G64 G93", *lines, "G94 G60 G1"])
    return SINUMERIK.text(f"DO $A_OUT[1]=1\n{path}\nDO $A_OUT[1]=0\nG4 F0.1")


def check(file: Path) -> tuple[float, float]:
    """Seconds of this process and its peak memory [GB] for reading and proving a program."""
    case = load_case("hexapod")
    began = time.process_time()
    read = read_program(file, case)
    assert prove_program(read.reading, read.guarantees).ok
    return time.process_time() - began, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def long_programs(folder: Path) -> list[list[str]]:
    """A program of 100 000 blocks in two languages, each checked in a process of its own."""
    most = load_case("hexapod").need_settings(SinumerikAxes, "a program").most_blocks
    framed = SINUMERIK.text("").count("\n") + 10
    texts = {"long.ngc": dense_lines(BLOCKS), "long.mpf": polynomials(most - framed)}
    rows = []
    for name, text in texts.items():
        (folder / name).write_text(text)
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            seconds, memory = pool.submit(check, folder / name).result()
        figure = f"{text.count(chr(10))} lines of {name}: read and checked (processor time, peak memory)"
        rows.append([figure, f"{seconds:.1f} s, {memory:.2f} GB", "20 s, 1 GB"])
    return rows
