"""Errors of the forces that a result expects in another motion, by their causes.

A machine off its case by sizes p of known deviations reads D p more than the case expects; its parameters were
estimated with the same p, so that they are off by B p beside their noise e. What is expected is therefore off by
(D - A B) p - A e: near the motion of the run that parameters are from, the two cancel. Sizes that a run has told are
off by what it left open of them alone.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from cases.base.units import Array
from cases.tolerances import kind_of
from identification.findings.left_out import LeftOut
from identification.findings.tolerances import UNITS, effects_of, turns_of
from identification.results.result import Result

PARAMETERS = "parameters"  # kind of what noise of their run makes of them


class Errors(NamedTuple):
    """Errors of rows that follow from forces, each a sum of factors times independent standard normal sizes."""

    by_tolerance: Mapping[str, Array]  # of a deviation of each size of a tolerance, shapes (.., k), by its key
    white: Array  # by white noise of the run that the parameters are from, shape (.., q)
    robust: Array  # by that noise with memory, and all else that its residuals showed, shape (.., q)
    scores: Array  # by what noise made of the scores that told sizes, shape (.., s); part of the two above
    of_values: Array  # less u by the same, shape (u, s)

    @property
    def variances(self) -> dict[str, Array]:
        """Variances of the rows by kinds of causes, shapes (..)."""
        kinds: dict[str, Array] = {PARAMETERS: np.maximum((self.white**2).sum(-1), (self.robust**2).sum(-1))}
        for key, factors in self.by_tolerance.items():
            kinds[kind_of(key)] = kinds.get(kind_of(key), 0.0) + (factors**2).sum(axis=-1)
        return kinds


def stated_sizes(result: Result) -> dict[str, float]:
    """One deviation of each tolerance that a result counts, by its key [SI]."""
    tolerances = result.case.tolerances
    stated = {} if tolerances is None else dict(tolerances.stated())
    return {key: stated[key] * UNITS[key.rpartition("_")[2]] for key in result.biases if key in stated}


def effects_in(left_out: LeftOut, result: Result) -> dict[str, Array]:
    """How the forces of a motion change with a deviation of each size, D, shapes (n, 6, k), by keys of tolerances."""
    return _by_size(left_out, result, effects_of, (len(left_out.t), 6))


def turns_in(left_out: LeftOut, result: Result) -> dict[str, Array]:
    """How {P} is turned in {B} by a deviation of each size, about axes of {B}, shapes (n, 3, k) [rad], by keys."""
    return _by_size(left_out, result, turns_of, (len(left_out.t), 3))


def _by_size(
    left_out: LeftOut, result: Result, effects: Callable[[LeftOut, str], Array], shape: tuple[int, int]
) -> dict[str, Array]:
    errors = {}
    for key, deviation in stated_sizes(result).items():
        columns, count = deviation * effects(left_out, key), result.biases[key].shape[1]
        errors[key] = columns if columns.shape[-1] == count else np.zeros((*shape, count))
    return errors


def errors_of(result: Result, matrices: Array, effects: Mapping[str, Array]) -> Errors:
    """Errors of rows of forces, true less expected.

    Args:
        result: whose parameters they are expected by.
        matrices: A, shape (.., u).
        effects: D, of a deviation of each size of a tolerance that the result counts, shapes (.., k), by its key.
    """
    biases, left_open = result.biases, result.left_open
    by_key = {key: effects.get(key, 0.0) - matrices @ bias for key, bias in biases.items()}
    through, scores = np.zeros((*matrices.shape[:-1], 0)), np.zeros((len(result.values), 0))
    white_scores = robust_scores = np.zeros((0, 0))
    if left_open is not None:
        sizes = left_open.of_keys(effects)
        by_key |= {key: sizes @ stays - matrices @ biases[key] for key, stays in left_open.remains.items()}
        scores = left_open.of_values
        through = matrices @ scores - sizes @ left_open.gain
        white_scores, robust_scores = (left_open.noise_of(robust) for robust in (False, True))
    sources = [
        np.concatenate([through @ root_of(noise), matrices @ root_of(covariance - scores @ noise @ scores.T)], axis=-1)
        for noise, covariance in ((white_scores, result.covariance), (robust_scores, random_of(result)))
    ]
    return Errors(by_key, sources[0], sources[1], through, scores)


def random_of(result: Result) -> Array:
    """Covariance of u by all but tolerances: noise with memory, and what residuals showed, shape (u, u)."""
    by_tolerances = sum((b @ b.T for b in result.biases.values()), np.zeros_like(result.covariance))
    return np.asarray(result.covariance_robust - by_tolerances)


def root_of(covariance: Array) -> Array:
    """A factor F of a covariance F F^T that may be singular, or a little negative by rounding, shape (u, u)."""
    if not covariance.size:
        return covariance
    scale = np.sqrt(np.diag(covariance).clip(0.0))
    scale = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(values.clip(0.0)))
