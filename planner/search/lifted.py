"""A program whose states are unknowns too, each tied to the motion's own unknowns by a linear equation.

A limit of a state then depends on the few components of that state, not on all unknowns that move it, and so do its
second derivatives. Newton's steps stay the same, but the solver's matrices become far sparser: of a Fourier series
every unknown moves every state. Those of splines and moves depend on few unknowns as they are.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from planner.search.program import NonlinearProgram
from planner.search.rows import LinearRows, StateRows
from planner.search.states import LinearStates

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def lifted(program: NonlinearProgram, unknowns: Array) -> tuple[NonlinearProgram, Array]:
    """The program with components of states as unknowns behind its own, where all of its own move every state.

    Args:
        program: as it is where blocks of its states depend on few unknowns each.
        unknowns: shape (n,).

    Returns:
        The program in n + Z unknowns, and all of them at the same motion.
    """
    from scipy.sparse import csr_array, eye_array, hstack

    rows = [part for part in program.rows if len(part.lower)]
    limits = [part for part in rows if isinstance(part, StateRows)]
    states = limits[0].states if limits else None
    alike = all(part.states is states for part in limits)
    if not isinstance(states, LinearStates) or len(states.index) > 1 or not alike:
        return program, unknowns
    used = np.logical_or.reduce([p.needed[:, :, None] & p.kernel.uses for p in limits])
    scale = np.abs(states.slope).sum(axis=3).max(axis=(0, 1))  # components of order one, like the unknowns
    scale[scale == 0.0] = 1.0
    n, more = program.unknowns, int(used.sum())
    place = np.full(used.shape, -1)
    place[used] = n + np.arange(more)
    slopes = np.zeros((more, n))
    slopes[:, states.index[0]] = states.slope[used] / scale[np.nonzero(used)[2], None]
    ties = LinearRows.equation(csr_array(hstack([csr_array(slopes), -eye_array(more)])), 0.0)
    wide = [_of_components(p, place, scale) if isinstance(p, StateRows) else _widened(p, n + more) for p in rows]
    free = np.full(more, np.inf)
    lower, upper = np.concatenate([program.lower, -free]), np.concatenate([program.upper, free])
    wider = replace(program, rows=(*wide, ties), lower=lower, upper=upper)
    return wider, np.concatenate([unknowns, slopes @ unknowns])


def _of_components(part: StateRows, place: Indices, scale: Array) -> StateRows:
    """Its rows as functions of components of states, which are unknowns: each state is a block of its own.

    Args:
        place: number of each component among all unknowns, shape (B, S, d).
        scale: their units, shape (d,).
    """
    states, needed = part.states, part.needed
    assert isinstance(states, LinearStates)
    components = np.flatnonzero(part.kernel.uses)
    index = place[needed][:, components]
    slope = np.zeros((len(index), 1, len(scale), len(components)))
    slope[:, 0, components, np.arange(len(components))] = scale[components]
    own = LinearStates(index, states.offset[needed][:, None], slope)
    return replace(part, states=own, chosen=part.chosen[needed][:, None])


def _widened(part: LinearRows, unknowns: int) -> LinearRows:
    """The same rows, which do not depend on further unknowns."""
    table = part.matrix
    wide = type(table)((table.data, table.indices, table.indptr), shape=(table.shape[0], unknowns))
    return replace(part, matrix=wide)
