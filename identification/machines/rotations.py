"""Orientations, twists and their rates as CasADi expressions."""

import casadi as ca


def rotation(rpy: ca.SX) -> ca.SX:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw [rad], shape (3,) -> (3, 3)."""
    sr, cr = ca.sin(rpy[0]), ca.cos(rpy[0])
    sp, cp = ca.sin(rpy[1]), ca.cos(rpy[1])
    sy, cy = ca.sin(rpy[2]), ca.cos(rpy[2])
    return ca.vertcat(
        ca.horzcat(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        ca.horzcat(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        ca.horzcat(-sp, cp * sr, cp * cr),
    )


def rate_matrix(rpy: ca.SX) -> ca.SX:
    r"""The matrix of (39), shape (3, 3): times (roll', pitch', yaw') it is omega in {B}.

    .. math::
        T = \begin{pmatrix}
        \cos\theta \cos\psi & -\sin\psi & 0 \\
        \cos\theta \sin\psi & \cos\psi & 0 \\
        -\sin\theta & 0 & 1
        \end{pmatrix}

    with pitch :math:`\theta` and yaw :math:`\psi`.
    """
    sp, cp = ca.sin(rpy[1]), ca.cos(rpy[1])
    sy, cy = ca.sin(rpy[2]), ca.cos(rpy[2])
    return ca.vertcat(
        ca.horzcat(cp * cy, -sy, 0),
        ca.horzcat(cp * sy, cy, 0),
        ca.horzcat(-sp, 0, 1),
    )


def twist(pose: ca.SX, rates: ca.SX) -> ca.SX:
    r"""(37): velocity of the origin of {P} and angular velocity, both in {B}, shape (6,) [m/s, rad/s].

    .. math::
        \begin{pmatrix} v \\ \omega \end{pmatrix} = \begin{pmatrix} 1 & 0 \\ 0 & T \end{pmatrix} \dot{x}
    """
    return ca.vertcat(rates[:3], rate_matrix(pose[3:]) @ rates[3:])


def twist_rate(pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> ca.SX:
    r"""(38): time derivative of the twist, shape (6,) [m/s^2, rad/s^2].

    .. math::
        \begin{pmatrix} \dot{v} \\ \dot{\omega} \end{pmatrix} =
        \begin{pmatrix} 1 & 0 \\ 0 & T \end{pmatrix} \ddot{x} +
        \begin{pmatrix} 0 & 0 \\ 0 & \dot{T} \end{pmatrix} \dot{x}
    """
    matrix = rate_matrix(pose[3:])
    matrix_rate = ca.reshape(ca.jtimes(ca.vec(matrix), pose[3:], rates[3:]), 3, 3)
    return ca.vertcat(accelerations[:3], matrix @ accelerations[3:] + matrix_rate @ rates[3:])


def pose_rates(pose: ca.SX, motion: ca.SX) -> ca.SX:
    """Time derivatives of a pose from its twist, shape (6,) [m/s, rad/s]: (37) solved for them."""
    return ca.vertcat(motion[:3], ca.solve(rate_matrix(pose[3:]), motion[3:]))


def gibbs(turn: ca.SX) -> ca.SX:
    r"""Gibbs vector of a rotation matrix by an angle about an axis, shape (3,) [-]; singular only at half a turn.

    .. math::
        g = a \tan\frac{\varphi}{2} = \frac{1}{1 + \mathrm{tr} R}
        \begin{pmatrix} R_{32} - R_{23} \\ R_{13} - R_{31} \\ R_{21} - R_{12} \end{pmatrix}
    """
    twice_sine_axis = ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    return twice_sine_axis / (1 + turn[0, 0] + turn[1, 1] + turn[2, 2])


def rpy(turn: ca.SX) -> ca.SX:
    """Roll, pitch, yaw of a rotation matrix with |pitch| < 90 degrees, shape (3,) [rad]."""
    return ca.vertcat(
        ca.atan2(turn[2, 1], turn[2, 2]),
        ca.atan2(-turn[2, 0], ca.sqrt(turn[2, 1] ** 2 + turn[2, 2] ** 2)),
        ca.atan2(turn[1, 0], turn[0, 0]),
    )
