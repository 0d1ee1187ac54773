"""What noise of the struts does to the regressor of a periodic run, whose acceleration is a Fourier series.

With dA = G(t) e''(t), G periodic and e'' of harmonics up to H + B, the harmonics up to H of dA hold those of e'' that G
shifts there: sum_t dA^T W dA has the mean (2 H + 1) sum_m G_m^* W G_m sum_h s_h over |h| <= H + B and |h + m| <= H, G_m
being the Fourier coefficients of G and s_h the power of e'' at the harmonic h.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft

from cases.sensors import Sensors
from identification.hexapod import Kinematics
from identification.noise.effects import acceleration_effects
from identification.periodic.averaging import PeriodicRun

Array = NDArray[np.float64]

SAME_STEP = 0.2  # of an encoder's step, by which struts of periods differ if their steps are the same; else 0.4 or more


def strut_noise_moment(run: PeriodicRun, motion: Kinematics, sensors: Sensors, w: Array) -> tuple[Array, float]:
    """Expected sum of dA^T W dA over the evaluated instants, shape (u, u), and the variance of e'' [m^2/s^4].

    Steps of encoders are averaged over periods like noise where the struts do not repeat to a part of a step; where
    they do, the steps repeat with them.

    Args:
        run: the run.
        motion: at its fine instants.
        sensors: with noise of the struts.
        w: W for one sample, shape (6, 6).
    """
    periods = len(run.scatter.series) if run.scatter is not None else 1
    repeats = periods if run.part.misfit < SAME_STEP * sensors.strut_step else 1
    recorded = (sensors.strut_variance or 0.0) + (repeats - 1) * sensors.strut_step**2 / 12.0
    orders = np.arange(-run.struts.harmonics, run.struts.harmonics + 1)
    power = recorded / run.samples * (orders * run.struts.omega) ** 4.0
    shifts = np.arange(-run.harmonics - run.struts.harmonics, run.harmonics + run.struts.harmonics + 1)
    passed = np.abs(orders + shifts[:, None]) <= run.harmonics
    root = np.linalg.cholesky(w).T
    moment = np.zeros((len(run.model.parameters),) * 2)
    for change in acceleration_effects(run.hexapod, run.model, motion):
        seen = fft(root @ change, axis=0)[shifts] / len(change)
        moment += np.einsum("m,mku,mkv->uv", passed @ power, seen.conj(), seen, optimize=True).real
    return run.points * moment, float(power.sum())
