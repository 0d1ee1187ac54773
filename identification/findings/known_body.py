"""A fit with what `[bounds]` of its case say of the body as a prior, and what to say of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cases.tolerances import BOUNDS
from identification.estimation.bounded import Bounded
from identification.finding import Finding, Kind, note
from identification.findings.told import LeftOpen
from identification.findings.tolerances import Share
from identification.samples.samples import Fitted
from identification.texts import parameter_words


def with_bounds(fitted: Fitted, known: Bounded, counted: bool) -> Fitted:
    """A fit with the values that bounds make of it; what its errors were by is less.

    Args:
        fitted: the fit.
        known: what bounds make of it.
        counted: whether deviations that allow for all count those of the bounds too.
    """
    fit, remaining = fitted.fit, known.kept
    more = known.biases @ known.biases.T if counted else np.zeros_like(remaining)
    moved = replace(
        fit,
        values=known.values,
        covariance=remaining @ fit.covariance @ remaining.T,
        covariance_robust=remaining @ fit.covariance_robust @ remaining.T + more,
        residuals=fitted.regression.residuals(known.values),
    )
    parameters = slice(len(fitted.samples.model.names))
    change = known.values[parameters] - fit.values[parameters]
    by = fitted.regression.regressors[:, :, parameters] @ change
    return fitted._replace(fit=moved, residuals=fitted.residuals - by / np.reshape(fitted.samples.scale, (-1, 1)))


def shares_with_bounds(shares: tuple[Share, ...] | None, known: Bounded) -> tuple[Share, ...]:
    """What tolerances and bounds do to the values, each with its key; None of tolerances where none are counted."""
    moved = [share._replace(biases=known.kept @ share.biases) for share in shares or ()]
    return (*moved, Share(BOUNDS, known.biases, np.zeros((0, 6, known.biases.shape[1]))))


def left_open_with_bounds(findings: Sequence[Finding], known: Bounded) -> tuple[Finding, ...]:
    """Findings on sizes that were told, where noise in these moves the parameters by less."""
    moved = []
    for finding in findings:
        entries = finding.quantity.get("told_left_open")
        if entries is not None:
            left_open = LeftOpen.from_json(entries)
            parameters = slice(len(left_open.of_values))
            of_values = known.kept[parameters, parameters] @ left_open.of_values
            quantity = {"told_left_open": left_open._replace(of_values=of_values).to_json()}
            finding = replace(finding, quantity={**finding.quantity, **quantity})
        moved.append(finding)
    return tuple(moved)


def bounds_finding(known: Bounded) -> Finding:
    """That bounds of the body are part of the estimate."""
    words = ", ".join(parameter_words(name) for name in known.names)
    sentence = f"[bounds] of the case are part of the estimate, as priors of {words}: uniform between their ends"
    return note(Kind.ESTIMATOR, sentence, bounds_as_priors=list(known.names))
