"""A run without its external contacts: searched for in what a fit leaves, left out, fitted again."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.estimation.estimators import Method, Problem, robust_of
from identification.findings.contact import Calm, Contact, find_contacts, least_trimmed_squares, touched
from identification.findings.plausibility import MOST_NAMED, places
from identification.findings.residual_checks import systematic
from identification.fitting import Fitted, fit_samples
from identification.model import Model
from identification.recording import Recording
from identification.result import Delay
from identification.samples import PART, Samples, fair_part

Array = NDArray[np.float64]

SEARCHES = 4  # for contacts; each finds what the one before hid
CALMER = 0.7  # of the residuals, that leaving a long contact out must at least take
MOST_TOUCHED = 0.25  # of the samples in contact; more is no identification run


def free_of_contact(
    recording: Recording, fitted: Fitted, how: Method, problem: Problem, held: Delay | None = None
) -> tuple[Fitted, tuple[Contact, ...]]:
    """The fit to the samples out of contact, and the contacts; of averaged periods the fit as it is.

    Args:
        recording: names rows.
        fitted: all samples with their fit.
        how: estimator.
        problem: the run's model and weights.
        held: the delay, where it is not estimated.

    Raises:
        IdentificationError: too much of the run is in contact.
    """
    contacts: tuple[Contact, ...] = ()
    run, moving = fitted.samples, fitted
    if not run.consecutive:
        return fitted, contacts
    forces, matrices = run.forces, fitted.matrices
    for _ in range(SEARCHES):
        # A contact biases the fit, and so the search for it: a robust fit begins, better ones follow.
        left = forces - matrices @ _without_pull(matrices, forces, run, how, problem)
        before, contacts = contacts, find_contacts(run.t, left, run.model.structure, forces - left)
        if contacts == before:
            break
        rows = touched(run.t, contacts)
        require_free(float(rows.mean()), [contact_told(recording, contact) for contact in contacts], run.model)
        moving = fit_samples(run.without(rows), how, problem, moving.at, held)
        matrices = run.regressors(moving.at)
    if systematic(moving.fit, run.noise_correlation):
        longer = _long_contacts(run, moving)
        rows = touched(run.t, longer)
        freed = fit_samples(run.without(rows), how, problem, moving.at, held) if 0.0 < rows.mean() < 1.0 else moving
        if _spread(freed) < CALMER * _spread(moving) and not systematic(freed.fit, run.noise_correlation):
            require_free(float(rows.mean()), [contact_told(recording, contact) for contact in longer], run.model)
            moving, contacts = freed, longer
    return moving, contacts


def _long_contacts(run: Samples, moving: Fitted) -> tuple[Contact, ...]:
    """Contacts of up to half a run, by what the half of the samples that agree best says of all."""
    matrices, forces = run.regressors(moving.at), run.forces
    every = slice(None, None, -(-len(forces) // PART))  # of a long run some say where, on the scale of a search
    step = float(np.median(np.diff(run.t[every])))
    half = least_trimmed_squares(matrices[every], forces[every], moving.w, step)
    if half is None:
        return ()
    left = forces - matrices @ half.values
    return find_contacts(run.t, left, run.model.structure, forces - left, Calm.of(left[every][half.explained]))


def _spread(moving: Fitted) -> float:
    """Rms of the weighted residuals."""
    left = moving.fit.residuals
    return float(np.sqrt(np.mean(np.einsum("ni,ij,nj->n", left, moving.w, left))))


def require_free(share: float, contacts: Sequence[str], model: Model) -> None:
    """Raises IdentificationError where too much of a run is in contact.

    Args:
        share: of its samples.
        contacts: what is told of each.
        model: that the forces leave.
    """
    if share > MOST_TOUCHED:
        if model.needs_position and not model.needs_motion:
            raise IdentificationError(
                f"the forces leave model {model.number} in {100 * share:.0f} % of the samples: it has no inertia, "
                "which moves them in a motion; choose a model from 6 to 9, or identify standstills"
            )
        raise IdentificationError(
            f"the forces leave the model in {100 * share:.0f} % of the samples, as in contact ({contacts[0]}); an "
            "identification run must be free: check columns, struts and model, or record again"
        )


def _without_pull(matrices: Array, forces: Array, run: Samples, how: Method, problem: Problem) -> Array:
    """U of a robust fit, shape (u,), of a long run to a part of it: gross deviations do not draw it to them."""
    selection, part = how.selection(run.model), fair_part(len(forces))
    matrices, forces = matrices[part], forces[part]
    pooled = problem.pooled if problem.noise is None else bool(np.ptp(problem.noise.force) == 0.0)
    robust = robust_of(replace(problem, pooled=pooled, filtered=run.filtered))
    free = robust(matrices @ selection.basis, forces - matrices @ selection.offset, selection.names).values
    return np.asarray(selection.offset + selection.basis @ free)


def contacts_told(recording: Recording, contacts: Sequence[Contact]) -> list[str]:
    """What people are told of contacts: one sentence, with a count and the longest places where there are several."""
    if len(contacts) < 2:
        return [contact_told(recording, contact) for contact in contacts]
    longest = sorted(contacts, key=lambda contact: contact.start - contact.end)[:MOST_NAMED]
    total, peak = sum(c.end - c.start for c in contacts), max(c.peak for c in contacts)
    named = "; ".join(contact_told(recording, contact) for contact in longest)
    return [f"{len(contacts)} external contacts, {total:.2g} s in all, up to {peak:.3g} N; the longest: {named}"]


def contact_told(recording: Recording, contact: Contact) -> str:
    """What people are told of a contact, with its rows."""
    assert recording.t is not None
    rows = (recording.t >= contact.start) & (recording.t <= contact.end)
    return (
        f"{places(recording.lines, rows)}: external contact from {contact.start:.3f} to {contact.end:.3f} s, up to "
        f"{contact.peak:.3g} N"
    )
