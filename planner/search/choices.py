"""Orders and periods to choose from where a request leaves them free.

A Fourier motion from rest to rest within a given duration lasts a whole number of periods, so the base frequency takes
discrete values only: what an optimiser would treat as a variable is searched through instead, value by value. Worth
a look are those whose highest harmonic lies near the frequency at which a harmonic reaches its limits of velocity and
of acceleration at once, A / (2 pi V): far below it accelerations go to waste, far above it velocities.
"""

from dataclasses import replace

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from planner.request import Request

ORDERS = range(2, 8)
LOWEST, HIGHEST = 1 / 3, 2.0  # of the highest harmonic, in units of the frequency at which both limits meet


def choices(request: Request, case: Case) -> tuple[Request, ...]:
    """Requests with every order and period worth a look; the request itself where neither is free.

    Raises:
        HexciteError: the duration is too short for any.
    """
    if request.family != "fourier" or not (request.free_order or request.free_period):
        return (request,)
    box = case.need_machine("planning")[2].motion
    meets = float(np.max(box.acceleration / box.rate)) / (2 * np.pi)
    cutoff = case.recording.filter_cutoff_Hz
    heard = np.inf if cutoff is None else cutoff / 2
    found = []
    for order in ORDERS if request.free_order else (request.order,):
        fewest = 2 if order == 1 else 1
        most = max(fewest, int(HIGHEST * meets * request.duration / order))
        for periods in range(fewest, most + 1) if request.free_period else (request.periods,):
            period = request.duration / periods
            inside = LOWEST * meets <= order / period <= HIGHEST * meets or not request.free_period
            if inside and order / period <= heard:
                found.append(replace(request, order=order, period=period, free_order=False, free_period=False))
    if not found:
        shortest = min(ORDERS if request.free_order else (request.order,)) * LOWEST / meets
        raise HexciteError(
            f"no period fits: {request.duration:g} s is too short or the filter of the evaluation too low; choose "
            f"--duration {max(2.0, np.ceil(shortest)):g} or more, or fix --period"
        )
    return tuple(found)
