"""What is left of a long run after its blocks: a triangle, sums, contacts and a few residuals."""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.sensors import Sensors
from identification.estimation.compressed import Compressed, scores, triangle
from identification.estimation.estimator import WEIGHT_ROUNDS, WEIGHT_TOLERANCE
from identification.estimation.fit import long_run_covariance
from identification.findings.contact import NEAR, Calm, Contact, find_contacts, touched
from identification.noise.sources import RegressorNoise, regressor_noise
from identification.runs.evaluation import Run
from identification.signals import Filter

Array = NDArray[np.float64]

MOST_KEPT = 20_000  # residuals kept for the plots
SAMPLED = 300  # samples of a block by which noise in the regressors is told: a mean over the run, to a percent or two


class Touch(NamedTuple):
    """A contact, and its first and last row as messages name them."""

    contact: Contact
    first: str
    last: str


def _merged(found: tuple[Touch, ...], more: list[Touch]) -> tuple[Touch, ...]:
    """Contacts in the order of time; those that go on in the next block as one."""
    merged = list(found)
    for touch in more:
        if merged and touch.contact.start - merged[-1].contact.end < NEAR:
            one = merged.pop()
            contact = Contact(one.contact.start, touch.contact.end, max(one.contact.peak, touch.contact.peak))
            touch = Touch(contact, one.first, touch.last)
        merged.append(touch)
    return tuple(merged)


@dataclass(slots=True)
class Total:
    """What is left of a run after its blocks: a triangle and sums.

    Args:
        delay: at which the blocks are evaluated [s].
        values: u whose residuals are judged, shape (u,).
        root: C with W = C^T C for one sample, shape (6, 6).
        weighing: whether the weights are to be estimated from what the channels leave.
        sensors: with noise of struts or accelerations, whose effect is to be told; None: it is not.
        calm: what noise leaves of the forces, as the reading before told; None: do not look for contacts.
        known: contacts that the reading before found.
        smoothing: whether that of the forces is estimated.
        bend: what the reading before found of it [s^2].
    """

    delay: float
    values: Array
    root: Array
    weighing: bool
    sensors: Sensors | None = None
    calm: Calm | None = None
    known: tuple[Touch, ...] = ()
    smoothing: bool = False
    bend: float = 0.0
    triangle: Array | None = None
    rows: int = 0
    samples: int = 0
    squares: Array = field(default_factory=lambda: np.zeros(6))
    products: Array = field(default_factory=lambda: np.zeros((6, 6)))
    information: Array | None = None
    gradient: Array | None = None
    meat: Array | None = None
    noise: RegressorNoise | None = None
    found: tuple[Touch, ...] = ()
    touched: int = 0
    looked_at: int = 0
    pieces: list[Array] = field(default_factory=list)
    thinning: int = 1

    def add(self, run: Run) -> None:
        """One block more; what it leaves at earlier values."""
        if not len(run.rows):
            return
        run = replace(run, smoothing=self.smoothing)
        matrices, nuisances = run.linearised(self.delay, self.values)
        forces = run.forces
        left = forces - matrices @ self.values
        if self.bend:
            left -= self.bend * nuisances[:, :, 0]
        if self.calm is not None:
            keep = ~self._contacts(run, forces, left)
            self.looked_at, self.touched = self.looked_at + len(keep), self.touched + int(np.sum(~keep))
            if not keep.all():
                if not keep.any():
                    return
                run, matrices, nuisances = run.without(~keep), matrices[keep], nuisances[keep]
                forces, left = forces[keep], left[keep]
        augmented = np.dstack([matrices, nuisances])
        joined = self.root @ np.dstack([augmented, forces])
        own = triangle(joined.reshape(-1, joined.shape[2]))
        self.triangle = own if self.triangle is None else triangle(np.vstack([self.triangle, own]))
        self.rows += len(run.rows)
        self.samples += run.samples
        self.squares = self.squares + np.sum((run.recorded_forces - (forces - left)) ** 2, axis=0)
        self.products = self.products + left.T @ left
        if self.weighing:
            information = np.einsum("nku,nkv->kuv", augmented, augmented, optimize=True)
            self.information = information if self.information is None else self.information + information
            slope = np.einsum("nku,nk->ku", augmented, left)
            self.gradient = slope if self.gradient is None else self.gradient + slope
        meat = long_run_covariance(scores(joined[:, :, :-1], left @ self.root.T, np.ones(6)))
        self.meat = meat if self.meat is None else self.meat + meat
        if self.sensors is not None:
            some = replace(run, rows=run.rows[:: max(1, len(run.rows) // SAMPLED)])
            self.noise = regressor_noise(some, self.root.T @ self.root, self.delay, self.sensors).joined(self.noise)
        self.pieces.append(np.hstack([left, forces])[:: self.thinning])
        if sum(map(len, self.pieces)) > MOST_KEPT:
            self.pieces = [np.vstack(self.pieces)[::2]]
            self.thinning *= 2

    def _contacts(self, run: Run, forces: Array, left: Array) -> NDArray[np.bool_]:
        """Samples of a block that a contact may have moved; what is found is kept with its rows."""
        here = find_contacts(run.t, left, run.model.structure, forces - left, self.calm)
        rows = [self._rows_of(run, contact) for contact in here]
        self.found = _merged(self.found, [Touch(c, *r) for c, r in zip(here, rows, strict=True)])
        return touched(run.t, (*here, *(t.contact for t in self.known)))

    @staticmethod
    def _rows_of(run: Run, contact: Contact) -> tuple[str, str]:
        assert run.recording.t is not None
        inside = np.flatnonzero((run.recording.t >= contact.start) & (run.recording.t <= contact.end))
        place = run.recording.lines.place
        return place(int(inside[0])), place(int(inside[-1]))

    @property
    def weights(self) -> Array:
        """Diagonal of W for one sample, shape (6,)."""
        return np.asarray(np.sum(self.root**2, axis=0))

    @property
    def kept(self) -> Array:
        """Residuals behind the filter, thinned, shape (k, 6)."""
        return np.vstack(self.pieces)[:, :6]

    @property
    def kept_forces(self) -> Array:
        """Forces behind the filter at the same samples, shape (k, 6)."""
        return np.vstack(self.pieces)[:, 6:]

    def compressed(self, offset: Array, basis: Array) -> Compressed:
        """The QR of all blocks as a function of what is free, u = offset + basis @ free.

        Args:
            offset: of parameters and nuisances, shape (u,).
            basis: shape (u, free).

        Raises:
            IdentificationError: no sample was left.
        """
        if self.triangle is None:
            raise IdentificationError("no sample of the window can be used; record again")
        columns, forces = self.triangle[:, :-1], self.triangle[:, -1]
        r = triangle(np.column_stack([columns @ basis, forces - columns @ offset]))
        return Compressed(r[:-1, :-1], r[:-1, -1], float(r[-1, -1] ** 2), 6 * self.rows)

    def new_weights(self, low_pass: Filter, alike: tuple[int, ...], basis: Array) -> Array:
        """W as `per_channel` finds it, in turns with what is free, from the sums of each channel, shape (6,).

        chi^2 of a channel at u + du is q - 2 g^T du + du^T I du with the sums q, g, I at u.

        Args:
            low_pass: that the samples went through.
            alike: channels with the same number have the same noise, shape (6,).
            basis: of what is free, shape (u, free).
        """
        assert self.information is not None
        assert self.gradient is not None
        own, slope = basis.T @ self.information @ basis, self.gradient @ basis
        scale = 1.0 / np.sqrt(np.einsum("kuu->u", own))
        own, slope = own * np.outer(scale, scale), slope * scale
        same = np.equal.outer(np.asarray(alike), np.asarray(alike)).astype(float)
        weights = self.weights
        for _ in range(WEIGHT_ROUNDS):
            inverse = np.linalg.inv(np.einsum("k,kuv->uv", weights, own))
            step = inverse @ (weights @ slope)
            left = np.diag(self.products) - 2.0 * slope @ step + np.einsum("kuv,u,v->k", own, step, step)
            freedom = self.rows * low_pass.noise_gain * low_pass.stride
            freedom_left = freedom - weights * np.einsum("kuv,uv->k", own, inverse)
            variance = same @ left * low_pass.stride / (same @ freedom_left)
            if not variance.min() > 0.0:
                raise IdentificationError("a channel fits without residual; its variance cannot be estimated: check it")
            settled = bool(np.all(np.abs(1.0 / variance / weights - 1.0) < WEIGHT_TOLERANCE))
            weights = np.asarray(1.0 / variance)
            if settled:
                break
        return weights
