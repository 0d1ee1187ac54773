"""External contact during an identification run: samples whose residuals are larger than noise.

The squared residual of a sample, in the metric of the channels' own robust covariance, is chi^2 with six degrees of
freedom where nothing touches; a contact is a stretch of samples that noise does not explain.

A contact that lasts for a large part of a run biases the fit so much that residuals no longer show where it is.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.special import chdtri, ndtri

from cases.base.errors import Code, IdentificationError
from cases.base.phrases import phrase
from cases.base.units import Array, Flags
from identification.estimation.estimators import EACH, huber
from identification.estimation.fit import Regression
from identification.finding import Finding, Kind, warning
from identification.recording.recording import Recording
from identification.samples.sample_checks import MOST_NAMED, places
from identification.samples.samples import Fitted
from identification.signals import fair_part
from identification.stretches import stretches

CHANCE = 1e-7  # for a sample by noise alone; two neighbours are needed, so that a run of an hour has no false contact
CLEAR = 3.0  # times the limit that a contact reaches somewhere; residuals of a wrong model creep over it here and there
SHARE = 0.2  # of the nearby change of the model's force, which residuals of a contact exceed
OWN = 3.0  # standard deviations of a channel's noise beside that share
CALM = 0.3  # quantile of the residuals that gives the noise: a contact may touch half of them
NEARBY = 0.03  # [s] before and after: a little more than the filter's memory
FEWEST = 2  # neighbouring samples above the limit
SHORTEST = 0.02  # [s] that a contact lasts; behind the filter no push is shorter
NEAR = 0.05  # [s] stretches closer than that are one contact
CONTACT_MARGIN = 0.03  # [s] beside a contact that may still be disturbed by it


class Contact(NamedTuple):
    """A stretch of time in which something pushed."""

    start: float  # [s]
    end: float  # [s]
    peak: float  # largest external force in it [N]; of a wrench, its force part


def _calm(residuals: Array) -> tuple[Array, Array, Array]:
    """Median, metric (a square of 1 is exceeded by noise with `CHANCE`) and deviation of channels, half untouched."""
    # The covariance is that of the inner half of the residuals, so that up to half of them may be touched; the median
    # of the distances, which noise fixes, removes what trimming took from it.
    centre = np.median(residuals, axis=0)
    centred = residuals - centre
    noise = np.quantile(np.abs(centred), CALM, axis=0) / ndtri((1 + CALM) / 2)
    scale = np.maximum(np.median(np.abs(centred), axis=0), np.finfo(float).tiny)
    scaled = centred / scale
    size = np.sum(scaled**2, axis=1)
    inverse = np.eye(6)
    for _ in range(3):
        inner = scaled[size <= np.median(size)]
        covariance = inner.T @ inner / max(len(inner), 1)
        covariance += 1e-9 * np.trace(covariance) * np.eye(6) + np.finfo(float).tiny * np.eye(6)
        inverse = np.linalg.inv(covariance)
        size = np.sum((scaled @ inverse) * scaled, axis=1)
    middle = float(np.median(size))
    if middle <= 0.0:
        return centre, np.zeros((6, 6)), noise
    # The residuals' spread changes over a real run; the upper quartile gives no false contacts where the median would.
    upper = float(np.quantile(size, 0.75)) / float(chdtri(6, 0.25))
    spread = max(middle / float(chdtri(6, 0.5)), upper)
    return centre, inverse / np.outer(scale, scale) / spread / float(chdtri(6, CHANCE)), noise


def find_contacts(t: Array, residuals: Array, structure: Array, expected: Array) -> tuple[Contact, ...]:
    """The contacts of a run, from its residuals.

    Args:
        t: time of the samples, ascending, shape (n,) [s].
        residuals: measured less expected, shape (n, 6) [N, or N and N m].
        structure: J^-T, shape (6, 6), for the external force.
        expected: forces of the model, shape (n, 6): where they change fast, a little error of time or of the model is
            not a contact.
    """
    centre, metric, noise = _calm(residuals)
    distance = np.sum(((residuals - centre) @ metric) * (residuals - centre), axis=1)
    # Where all channels but one leap, noise of the one that hardly changes is not contact.
    step = float(np.median(np.diff(t))) if len(t) > 1 else NEARBY
    width = 2 * max(1, round(NEARBY / step)) + 1
    change = maximum_filter1d(expected, width, axis=0) - minimum_filter1d(expected, width, axis=0)
    exceeded = np.any(np.abs(residuals) > SHARE * change + OWN * noise, axis=1)
    clear = (distance >= CLEAR) & exceeded
    wrench = np.linalg.norm((residuals @ structure.T)[:, :3], axis=1)
    contacts: list[Contact] = []
    for rows in stretches(distance > 1.0):
        if rows.stop - rows.start < FEWEST or not clear[rows].any():
            continue
        contact = Contact(float(t[rows.start]), float(t[rows.stop - 1]), float(wrench[rows].max()))
        if contacts and contact.start - contacts[-1].end < NEAR:
            before = contacts.pop()
            contact = Contact(before.start, contact.end, max(before.peak, contact.peak))
        contacts.append(contact)
    return tuple(contact for contact in contacts if contact.end - contact.start + step >= SHORTEST)


def touched(t: Array, contacts: tuple[Contact, ...]) -> Flags:
    """Samples that a contact may have moved, shape (n,)."""
    rows = np.zeros(len(t), dtype=bool)
    for contact in contacts:
        rows |= (t >= contact.start - CONTACT_MARGIN) & (t <= contact.end + CONTACT_MARGIN)
    return rows


SEARCHES = 4  # for contacts; each finds what the one before hid
MOST_TOUCHED = 0.25  # of the samples in contact; more is not an identification run


def free_of_contact(recording: Recording, fitted: Fitted) -> tuple[Fitted, tuple[Contact, ...]]:
    """The fit to the samples out of contact, and the contacts; of standstills the fit as it is.

    Raises:
        IdentificationError: too much of the run is in contact.
    """
    contacts: tuple[Contact, ...] = ()
    run, moving = fitted.samples, fitted
    if not run.nuisances:
        return fitted, contacts
    forces, matrices = fitted.regression.forces, fitted.regression.regressors[:, :, : len(run.model.names)]
    for _ in range(SEARCHES):
        # A contact biases the fit, and so the search for it: a robust fit begins, better ones follow.
        residuals = forces - matrices @ _without_pull(matrices, fitted)
        before, contacts = contacts, find_contacts(run.t, residuals, run.model.structure, forces - residuals)
        if contacts == before:
            break
        rows = touched(run.t, contacts)
        _require_free(recording, float(rows.mean()), contacts)
        moving = moving.again(run.without(rows))
        matrices = run.regressors(moving.at)
    return moving, contacts


def _require_free(recording: Recording, share: float, contacts: Sequence[Contact]) -> None:
    """Raises IdentificationError where contacts take too large a share of a run."""
    if share > MOST_TOUCHED:
        raise IdentificationError(
            problem=phrase(
                "contact",
                "the forces leave the model in {share} % of the samples, as in contact ({where})",
                share=f"{100 * share:.0f}",
                where=contact_sentence(recording, contacts[0]),
            ),
            remedy=phrase(
                "free_run",
                "an identification run must be free: check columns, drives, model (6 to 9 in motion) and the "
                "case's dimensions, or record again",
            ),
            code=Code.MISFIT,
        ).in_doubt()


def _without_pull(matrices: Array, fitted: Fitted) -> Array:
    """U of a robust fit, shape (u,), of a long run to a part of it: gross deviations do not bias it."""
    selection, part = fitted.method.selection(fitted.samples.model), fair_part(len(matrices))
    alike = fitted.regression.alike if fitted.whitening is None else EACH
    right = fitted.regression.forces[part] - matrices[part] @ selection.offset
    free = huber(Regression(matrices[part] @ selection.basis, right, selection.names, alike=alike))
    return np.asarray(selection.offset + selection.basis @ free)


def contact_findings(recording: Recording, contacts: Sequence[Contact]) -> list[Finding]:
    """A warning about contacts, with a count and the longest places where there are several."""
    if not contacts:
        return []
    longest = sorted(contacts, key=lambda contact: contact.start - contact.end)[:MOST_NAMED]
    text = "; ".join(contact_sentence(recording, contact) for contact in longest)
    if len(contacts) > 1:
        total, peak = sum(c.end - c.start for c in contacts), max(c.peak for c in contacts)
        text = f"{len(contacts)} external contacts, {total:.2g} s in all, up to {peak:.3g} N; the longest: {text}"
    return [warning(Kind.CONTACT, f"{text}; left out")]


def contact_sentence(recording: Recording, contact: Contact) -> str:
    """The sentence about a contact, with its rows."""
    assert recording.t is not None
    rows = (recording.t >= contact.start) & (recording.t <= contact.end)
    return (
        f"{places(recording.lines, rows)}: external contact from {contact.start:.3f} to {contact.end:.3f} s, up to "
        f"{contact.peak:.3g} N"
    )
