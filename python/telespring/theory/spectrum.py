"""Characteristic roots of one axis, with a certificate that none to the right was missed."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from telespring import _core
from telespring._types import Delay

if TYPE_CHECKING:
    from telespring.model import Dyad

__all__ = [
    "CertificateWarning",
    "Spectrum",
    "certified_roots",
    "characteristic_roots",
    "spectral_abscissa",
]


class CertificateWarning(RuntimeWarning):
    """The count of the roots does not confirm those that were found."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The rightmost characteristic roots of one axis.

    Attributes
    ----------
    roots : ndarray of complex
        The roots, 1/s, rightmost first, a pair's upper member first, without the rigid-body root.
    rigid_body : bool
        Whether s = 0 is a root besides: both handles are free and the robots can be carried off
        together.
    complete : bool
        Whether the argument principle counted exactly as many roots right of `depth` as were found.
    certificate : str
        The same in words, with both numbers where they differ.
    depth : float
        The line Re s = depth, 1/s, right of which roots were counted; -inf where there is no delay.
    """

    roots: NDArray[np.complex128]
    rigid_body: bool
    complete: bool
    certificate: str
    depth: float


def certified_roots(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    count: int = 8,
    axis: int | str = 0,
) -> Spectrum:
    """Rightmost characteristic roots with their certificate as a record.

    Parameters
    ----------
    dyad : Dyad
        The robots and what holds them.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    count : int
        How many roots to return, 1 to 1000; without any delay there are four in all.
    axis : int or str
        The axis by its index or its name.

    Returns
    -------
    Spectrum
        A certificate that failed is said there, not warned of.

    Raises
    ------
    InvalidInput
        Where a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> found = ts.certified_roots(ts.hman(), 71.2, 0.167)
    >>> found.complete, found.rigid_body, found.roots.shape
    (True, True, (8,))
    """
    return Spectrum(*_core.characteristic_roots(dyad, stiffness, delay, count, axis))


def characteristic_roots(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    count: int = 8,
    axis: int | str = 0,
) -> NDArray[np.complex128]:
    """Rightmost roots of P1(s) P2(s) - (k + c s)² exp(-T s), without the rigid-body root s = 0.

    T is the sum of both delays and P_i(s) = m_i s² + (b_i + c) s + k + kh_i: the denominator of
    Eq. 2 of [1]_, with operators and a coupling damper.

    Parameters
    ----------
    dyad : Dyad
        The robots and what holds them.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    count : int
        How many roots to return, 1 to 1000.
    axis : int or str
        The axis by its index or its name.

    Returns
    -------
    ndarray of complex
        The roots, 1/s, rightmost first; fewer than `count` only where there is no delay.

    Raises
    ------
    InvalidInput
        Where a value is out of its range.

    Warns
    -----
    CertificateWarning
        Where the argument principle does not confirm that no root was missed; `certified_roots`
        returns the same as a status.

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots".

    Examples
    --------
    >>> import telespring as ts
    >>> roots = ts.characteristic_roots(ts.hman(), 71.2, 0.175, count=4, axis="x")
    >>> bool(roots[0].real > 0), bool(roots[1] == roots[0].conj())
    (True, True)
    """
    found = certified_roots(dyad, stiffness, delay, count, axis)
    if not found.complete:
        warnings.warn(f"the roots' certificate is {found.certificate}", CertificateWarning, stacklevel=2)
    return found.roots


def spectral_abscissa(dyad: Dyad, stiffness: float, delay: Delay, axis: int | str = 0) -> float:
    """Largest real part of the characteristic roots, the rigid-body root left out.

    Parameters
    ----------
    dyad : Dyad
        The robots and what holds them.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    axis : int or str
        The axis by its index or its name.

    Returns
    -------
    float
        The spectral abscissa, 1/s; below zero every motion but the common drift decays.

    Raises
    ------
    InvalidInput
        Where a value is out of its range.

    Warns
    -----
    CertificateWarning
        Where the argument principle does not confirm that no root was missed.

    Examples
    --------
    >>> import telespring as ts
    >>> ts.spectral_abscissa(ts.hman(), 71.2, 0.160) < 0 < ts.spectral_abscissa(ts.hman(), 71.2, 0.175)
    True
    """
    value, complete, certificate = _core.spectral_abscissa(dyad, stiffness, delay, axis)
    if not complete:
        warnings.warn(f"the abscissa's certificate is {certificate}", CertificateWarning, stacklevel=2)
    return value
