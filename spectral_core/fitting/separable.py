"""Separable least squares: spectra enter a dichromatic model linearly, lobe parameters do not.

For given lobe parameters p the model of M spectra over W wavelengths is linear in the unknown spectra,

    y[m, w] = sum_f free[m, f](p) * spectrum[f, w] + flat[m](p) * level + fixed[m](p),

so the spectra and the level are eliminated exactly and only the few p are searched (variable projection). The
derivative of the eliminated problem is that of Kaufman; at the solution it gives the same covariance as the full
problem, whose inverse it is a Schur complement of.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError

__all__ = ["LinearBasis", "ModelTerms", "SeparableFit", "fit_separable", "grid_start"]

Array = NDArray[np.float64]

_NOTHING = 1.0e-60  # a column that no geometry lights more than this has no measurable coefficient
_ABSENT = 1.0e-10  # a column left with this share of its length after the others are removed counts as absent


@dataclass(frozen=True, slots=True, eq=False)
class ModelTerms:
    """Columns of the model at some p, and their derivatives by the P parameters.

    Parameters
    ----------
    free : ndarray (M, F)
        Coefficients of the F unknown spectra.
    flat : ndarray (M,), optional
        Coefficient of one unknown number, the same at all wavelengths.
    fixed : ndarray (M,), optional
        Known term, the same at all wavelengths.
    free_slopes : ndarray (P, M, F)
        Derivatives of `free`.
    flat_slopes, fixed_slopes : ndarray (P, M), optional
        Derivatives of `flat` and `fixed`.
    """

    free: Array
    free_slopes: Array
    flat: Array | None = None
    flat_slopes: Array | None = None
    fixed: Array | None = None
    fixed_slopes: Array | None = None


class LinearBasis:
    """Orthonormal columns of the linear part, one set per wavelength, under given weights.

    Parameters
    ----------
    terms : ModelTerms
        The model at some p.
    root_weights : ndarray (M, W)
        One over the standard deviation of each value, up to a common factor.
    """

    __slots__ = ("_columns", "_flat", "_flat_length", "_flat_shares", "_root", "_triangle")

    def __init__(self, terms: ModelTerms, root_weights: Array) -> None:
        self._root = root_weights
        columns = [terms.free[:, f, None] * root_weights for f in range(terms.free.shape[1])]
        count, wavelengths = len(columns), root_weights.shape[1]
        reach = np.linalg.norm(root_weights, axis=0)
        self._triangle = np.zeros((count, count, wavelengths))
        for f, column in enumerate(columns):
            length = np.linalg.norm(column, axis=0)
            for _ in range(2):  # Gram-Schmidt twice is enough (Kahan)
                for g in range(f):
                    share = np.sum(columns[g] * column, axis=0)
                    self._triangle[g, f] += share
                    column = column - share * columns[g]
            left = np.linalg.norm(column, axis=0)
            present = left > np.maximum(_ABSENT * length, _NOTHING * reach)
            self._triangle[f, f] = np.where(present, left, 0.0)
            columns[f] = np.where(present, column / np.where(present, left, 1.0), 0.0)
        self._columns = np.array(columns)
        self._flat: Array | None = None
        self._flat_length = 0.0
        self._flat_shares = np.zeros((count, wavelengths))
        if terms.flat is not None:
            flat = terms.flat[:, None] * root_weights
            whole = float(np.linalg.norm(flat))
            for _ in range(2):
                shares = np.sum(self._columns * flat, axis=1)
                self._flat_shares += shares
                flat = flat - np.sum(self._columns * shares[:, None, :], axis=0)
            self._flat_length = float(np.linalg.norm(flat))
            if self._flat_length > max(_ABSENT * whole, _NOTHING * float(np.linalg.norm(reach))):
                self._flat = flat / self._flat_length

    @property
    def level_is_determined(self) -> bool:
        """Whether the data tell the flat term from the free spectra.

        Returns
        -------
        bool
            False too when the model has no flat term.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return self._flat is not None

    def _back(self, right: Array) -> Array:
        """Solve the triangles: (..., F, W) -> (..., F, W); an absent column gets 0."""
        solution = np.zeros_like(right)
        for f in range(right.shape[-2] - 1, -1, -1):
            value = right[..., f, :] - sum(
                (self._triangle[f, g] * solution[..., g, :] for g in range(f + 1, right.shape[-2])),
                start=np.zeros(right.shape[-1]),
            )
            diagonal = self._triangle[f, f]
            solution[..., f, :] = np.where(diagonal > 0.0, value / np.where(diagonal > 0.0, diagonal, 1.0), 0.0)
        return solution

    def solve(self, data: Array) -> tuple[Array, Array, Array]:
        """Fit the linear part to data.

        Parameters
        ----------
        data : ndarray (..., M, W)
            Values; leading axes are fitted one by one.

        Returns
        -------
        spectra : ndarray (..., F, W)
            The free spectra; 0 where a column is absent.
        level : ndarray (...)
            Number of the flat term; 0 without one.
        residual : ndarray (..., M, W)
            Weighted residuals.

        Raises
        ------
        None.

        References
        ----------
        Golub and Van Loan, Matrix Computations, 5.2 (modified Gram-Schmidt).
        """
        weighted = data * self._root
        shares = np.einsum("fmw,...mw->...fw", self._columns, weighted)
        residual = weighted - np.einsum("fmw,...fw->...mw", self._columns, shares)
        level = np.zeros(data.shape[:-2])
        if self._flat is not None:
            along = np.einsum("mw,...mw->...", self._flat, residual)
            residual = residual - along[..., None, None] * self._flat
            level = along / self._flat_length
            shares = shares - level[..., None, None] * self._flat_shares
        return self._back(shares), level, residual

    def leverage(self) -> Array:
        """Tell the share of each value's noise that the linear part takes up.

        Returns
        -------
        ndarray (M, W)
            0 to 1.

        Raises
        ------
        None.

        References
        ----------
        Seber and Lee, Linear Regression Analysis, 10.2 (hat matrix).
        """
        taken = np.sum(self._columns**2, axis=0)
        return np.asarray(taken if self._flat is None else taken + self._flat**2)

    def covariance(self) -> tuple[Array, Array, float]:
        """Tell the covariance of the linear part at fixed p, for values of unit weight and variance.

        Returns
        -------
        variance : ndarray (F, W)
            Of the spectra.
        with_level : ndarray (F, W)
            Covariance of each with the level.
        level_variance : float
            Of the level; 0 without one.

        Raises
        ------
        None.

        References
        ----------
        Seber and Lee, Linear Regression Analysis, 3.2.
        """
        count = self._columns.shape[0]
        variance = np.zeros(self._triangle.shape[1:])
        for f in range(count):
            unit = np.zeros(self._triangle.shape[1:])
            unit[f] = 1.0
            variance += self._back(unit) ** 2
        if self._flat is None:
            return variance, np.zeros_like(variance), 0.0
        level = 1.0 / self._flat_length**2
        slope = -self._back(self._flat_shares)
        return variance + slope**2 * level, slope * level, level


@dataclass(frozen=True, slots=True, eq=False)
class SeparableFit:
    """Solution of a separable fit.

    Parameters
    ----------
    parameters : ndarray (P,)
        The p found.
    spectra : ndarray (F, W)
        The free spectra.
    level : float
        The flat term's number.
    fitted : ndarray (M, W)
        The model.
    cost : float
        Sum of squared weighted residuals.
    parameter_covariance : ndarray (P, P)
        Per unit variance; infinite diagonal where the data do not determine a parameter.
    spectrum_variance : ndarray (F, W)
        Per unit variance, with the uncertainty of p.
    spectrum_level_covariance : ndarray (F, W)
        Per unit variance, with the uncertainty of p.
    level_variance : float
        Per unit variance, with the uncertainty of p; infinite where the level is not determined.
    leverage : ndarray (M, W)
        Share of each value's noise that the linear part takes up.
    unknowns : int
        Number of fitted numbers.
    """

    parameters: Array
    spectra: Array
    level: float
    fitted: Array
    cost: float
    parameter_covariance: Array
    spectrum_variance: Array
    spectrum_level_covariance: Array
    level_variance: float
    leverage: Array
    unknowns: int


def _linearise(terms: ModelTerms, data: Array, root: Array) -> tuple[LinearBasis, Array, float, Array, Array, Array]:
    """Solve the linear part; the Jacobian (P, M, W) of the residual and what it does to the linear unknowns."""
    basis = LinearBasis(terms, root)
    known = data if terms.fixed is None else data - terms.fixed[:, None]
    spectra, level, residual = basis.solve(known)
    change = np.einsum("pmf,fw->pmw", terms.free_slopes, spectra)
    if terms.flat_slopes is not None:
        change = change + terms.flat_slopes[:, :, None] * level
    if terms.fixed_slopes is not None:
        change = change + terms.fixed_slopes[:, :, None]
    drift, level_drift, jacobian = basis.solve(change)
    return (
        basis,
        spectra,
        float(level),
        residual,
        -jacobian,
        np.concatenate([-drift.reshape(drift.shape[0], spectra.size), -level_drift[:, None]], axis=1),
    )


def _cost(model: Callable[[Array], ModelTerms], p: Array, data: Array, root: Array) -> float:
    terms = model(p)
    known = data if terms.fixed is None else data - terms.fixed[:, None]
    residual = LinearBasis(terms, root).solve(known)[2]
    return float(np.sum(residual * residual))


def grid_start(model: Callable[[Array], ModelTerms], candidates: Array, data: Array, root_weights: Array) -> Array:
    """Choose the candidate with the smallest cost, so that the search begins in the right valley.

    Parameters
    ----------
    model : callable
        Gives :class:`ModelTerms` for p (P,).
    candidates : ndarray (K, P)
        Points to try.
    data, root_weights : ndarray (M, W)
        Values, and one over their standard deviations.

    Returns
    -------
    ndarray (P,)
        The best candidate.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    costs = [_cost(model, candidate, data, root_weights) for candidate in candidates]
    return np.array(candidates[int(np.argmin(costs))])


def fit_separable(
    model: Callable[[Array], ModelTerms],
    start: Array,
    bounds: tuple[Array, Array],
    data: Array,
    root_weights: Array,
    iterations: int = 100,
) -> SeparableFit:
    """Search p by Levenberg and Marquardt's method, with the linear part eliminated at every step.

    Parameters
    ----------
    model : callable
        Gives :class:`ModelTerms` for p (P,).
    start : ndarray (P,)
        Where to begin.
    bounds : tuple of ndarray (P,)
        Ends of p.
    data, root_weights : ndarray (M, W)
        Values, and one over their standard deviations.
    iterations : int
        Most steps.

    Returns
    -------
    SeparableFit
        The solution.

    Raises
    ------
    FittingError
        If there are no more values than unknowns.

    References
    ----------
    Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, 413; Kaufman (1975), BIT 15, 49.
    """
    p = np.clip(np.asarray(start, dtype=np.float64), *bounds)
    basis, spectra, level, residual, jacobian, drift = _linearise(model(p), data, root_weights)
    unknowns = p.size + spectra.size + int(basis.level_is_determined)
    if data.size <= unknowns:
        raise FittingError(
            f"{data.size} measured values cannot determine {unknowns} unknowns: measure at more geometries"
        )
    cost = float(np.sum(residual * residual))
    damping = 1.0e-3
    for _ in range(iterations if p.size else 0):
        flat = jacobian.reshape(p.size, data.size)
        gradient = flat @ residual.ravel()
        # A parameter at an end of its range that would be pushed beyond it stays where it is in this step.
        blocked = ((p <= bounds[0]) & (gradient > 0.0)) | ((p >= bounds[1]) & (gradient < 0.0))
        flat = np.where(blocked[:, None], 0.0, flat)
        gram, gradient = flat @ flat.T, np.where(blocked, 0.0, gradient)
        scale = np.sqrt(np.diag(gram))
        if not scale.any():
            break
        scale = np.where(scale > 0.0, scale, 1.0)
        system, right = gram / np.outer(scale, scale), -gradient / scale
        for _ in range(30):
            step = np.linalg.solve(system + damping * np.eye(p.size), right) / scale
            trial = np.clip(p + step, *bounds)
            trial_cost = _cost(model, trial, data, root_weights)
            if trial_cost < cost:
                break
            damping = min(damping * 8.0, 1.0e12)
            if np.max(np.abs(trial - p)) < 1.0e-13 * (1.0 + np.max(np.abs(p))):
                break
        if not trial_cost < cost:
            break
        moved, stalled = float(np.max(np.abs(trial - p))), cost - trial_cost < 1.0e-10 * cost
        p, damping = trial, max(damping / 10.0, 1.0e-12)
        basis, spectra, level, residual, jacobian, drift = _linearise(model(p), data, root_weights)
        cost = float(np.sum(residual * residual))
        if stalled or moved < 1.0e-13 * (1.0 + float(np.max(np.abs(p)))):
            break
    terms = model(p)
    fitted = terms.free @ spectra
    if terms.flat is not None:
        fitted = fitted + terms.flat[:, None] * level
    if terms.fixed is not None:
        fitted = fitted + terms.fixed[:, None]
    covariance = _parameter_covariance(jacobian.reshape(p.size, data.size), float(np.linalg.norm(data * root_weights)))
    variance, with_level, level_variance = basis.covariance()
    known = np.where(np.isfinite(covariance), covariance, 0.0)
    spread = np.sum(drift * (known @ drift), axis=0)
    shift = np.einsum("p,pq,qk->k", drift[:, -1], known, drift)
    return SeparableFit(
        p,
        spectra,
        level,
        fitted,
        cost,
        covariance,
        variance + spread[:-1].reshape(spectra.shape),
        with_level + shift[:-1].reshape(spectra.shape),
        level_variance + float(spread[-1]) if basis.level_is_determined else np.inf,
        basis.leverage(),
        unknowns,
    )


def _parameter_covariance(jacobian: Array, size: float) -> Array:
    """Inverse of J J^T; directions that move the model by less than 1e-9 of the data are undetermined (infinite)."""
    if jacobian.shape[0] == 0:
        return np.zeros((0, 0))
    left, sizes, _ = np.linalg.svd(jacobian, full_matrices=False)
    seen = sizes > 1.0e-9 * size
    inverse = (left[:, seen] / sizes[seen] ** 2) @ left[:, seen].T
    blind = np.any(np.abs(left[:, ~seen]) > 1.0e-6, axis=1)
    inverse[np.diag_indices_from(inverse)] = np.where(blind, np.inf, np.diag(inverse))
    return np.asarray(inverse)
