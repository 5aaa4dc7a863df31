"""Mirror paths: bundles of rays with the monomials that their light will be multiplied by.

A bounce off a metal multiplies the light by w S_I + (1 - w), one off a plastic or a cloth by a multiple of S_I; so
after some bounces a ray carries a polynomial in the slots it met, with geometric weights. The film keeps short ones
exactly; longer ones are evaluated at the nodes of a wavelength grid, and the rays carry these.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene_spectra import SceneSpectra, Term
from .shading import SurfacePoints
from .tracing.columns import dot_rows

__all__ = ["PathBundle", "Polynomial", "merge_bundles", "mirror_directions", "multiply", "product_terms"]

Monomial = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Polynomial:
    """What the light of N rays is multiplied by on its way to the camera.

    Attributes
    ----------
    monomials : tuple of tuple of int, length J, or None
        Sorted slots of each monomial; None when the polynomial was evaluated at the nodes of a wavelength grid.
    weights : ndarray, shape (N, J) or (N, W)
        Geometric weight of each monomial, or the polynomial's value at each node.
    """

    monomials: tuple[Monomial, ...] | None
    weights: NDArray[np.floating[Any]]

    @classmethod
    def one(cls, count: int, dtype: np.dtype[Any]) -> Polynomial:
        """Give the polynomial of rays that come from the camera.

        Parameters
        ----------
        count : int
            Number of rays.
        dtype : numpy dtype
            Of the weights.

        Returns
        -------
        Polynomial
            The constant 1.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return cls(((),), np.ones((count, 1), dtype))

    def take(self, index: NDArray[np.int64] | slice) -> Polynomial:
        """Select rays.

        Parameters
        ----------
        index : ndarray of int64 or slice
            Which rays.

        Returns
        -------
        Polynomial
            Theirs.

        Raises
        ------
        IndexError
            From numpy if a ray is not there.

        References
        ----------
        Own design.
        """
        return Polynomial(self.monomials, self.weights[index])

    def at_nodes(self, spectra: SceneSpectra, nodes_nm: NDArray[np.float64]) -> Polynomial:
        """Evaluate at wavelengths; one that was is returned as it is.

        Parameters
        ----------
        spectra : SceneSpectra
            The reflectances that the slots stand for.
        nodes_nm : ndarray, shape (W,)
            Wavelengths (nm).

        Returns
        -------
        Polynomial
            With weights (N, W).

        Raises
        ------
        IndexError
            If a slot is not there.

        References
        ----------
        Own design.
        """
        if self.monomials is None:
            return self
        table = np.array([spectra.product_at(monomial, nodes_nm) for monomial in self.monomials])
        return Polynomial(None, self.weights @ table.astype(self.weights.dtype))


@dataclass(frozen=True, slots=True)
class PathBundle:
    """N rays on their way, which share the same monomials.

    Attributes
    ----------
    pixel : ndarray of int64, shape (N,)
        Flat index of the pixel that each ray serves.
    origin, direction : ndarray, shape (N, 3)
        Relative to the geometry's centre (m); unit directions.
    own : ndarray of int64, shape (N,)
        The triangle that each ray leaves.
    polynomial : Polynomial
        What the light that they find is multiplied by.
    """

    pixel: NDArray[np.int64]
    origin: NDArray[np.floating[Any]]
    direction: NDArray[np.floating[Any]]
    own: NDArray[np.int64]
    polynomial: Polynomial

    def __len__(self) -> int:
        return len(self.pixel)


def merge_bundles(bundles: list[PathBundle]) -> list[PathBundle]:
    """Join the bundles that carry the same monomials.

    Parameters
    ----------
    bundles : list of PathBundle
        Any number.

    Returns
    -------
    list of PathBundle
        One for each list of monomials, in the order of first appearance.

    Raises
    ------
    None.

    References
    ----------
    Own design.
    """
    alike: dict[tuple[Monomial, ...] | None, list[PathBundle]] = {}
    for bundle in bundles:
        alike.setdefault(bundle.polynomial.monomials, []).append(bundle)
    merged = []
    for monomials, group in alike.items():
        if len(group) == 1:
            merged.append(group[0])
            continue
        merged.append(
            PathBundle(
                np.concatenate([b.pixel for b in group]),
                np.concatenate([b.origin for b in group]),
                np.concatenate([b.direction for b in group]),
                np.concatenate([b.own for b in group]),
                Polynomial(monomials, np.concatenate([b.polynomial.weights for b in group])),
            )
        )
    return merged


def mirror_directions(points: SurfacePoints, part: slice) -> NDArray[np.floating[Any]]:
    """Directions in which the viewer's rays leave a mirror.

    Parameters
    ----------
    points : SurfacePoints
        The points.
    part : slice
        Which of them.

    Returns
    -------
    ndarray, shape (n, 3)
        Unit vectors on the outer side of the surface: where an interpolated normal would send a ray into the surface,
        the flat normal is used instead.

    Raises
    ------
    None.

    References
    ----------
    Law of reflection.
    """
    viewer, flat = points.to_viewer[part], points.geometric_normal[part]
    mirrored = _mirrored(viewer, points.normal[part])
    inward = dot_rows(mirrored, flat) <= 0
    return np.where(inward[:, None], _mirrored(viewer, flat), mirrored)


def _mirrored(viewer: NDArray[np.floating[Any]], normal: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    out = 2 * dot_rows(normal, viewer)[:, None] * normal - viewer
    result: NDArray[np.floating[Any]] = out / np.sqrt(dot_rows(out, out))[:, None]
    return result


def multiply(
    polynomial: Polynomial,
    coefficients: NDArray[np.floating[Any]],
    slots: tuple[int | None, ...],
    spectra: SceneSpectra,
    nodes_nm: NDArray[np.float64],
) -> Polynomial:
    """Multiply by one more bounce, sum over slots of coefficient x reflectance.

    Parameters
    ----------
    polynomial : Polynomial, N rays
        So far.
    coefficients : ndarray, shape (N, C)
        Geometric coefficients of the bounce, C at least 1.
    slots : tuple of int or None, length C
        The reflectances; None stands for the constant 1.
    spectra : SceneSpectra
        Used when the polynomial is carried at nodes.
    nodes_nm : ndarray, shape (W,)
        Those nodes.

    Returns
    -------
    Polynomial
        The product, with like monomials collected.

    Raises
    ------
    None.

    References
    ----------
    Tominaga 1996, Eq. 13, raised to the number of bounces.
    """
    if polynomial.monomials is None:
        table = np.array([spectra.product_at(() if s is None else (s,), nodes_nm) for s in slots])
        return Polynomial(None, polynomial.weights * (coefficients @ table.astype(coefficients.dtype)))
    collected: dict[Monomial, NDArray[np.floating[Any]]] = {}
    for column, slot in enumerate(slots):
        factor = coefficients[:, column]
        for j, monomial in enumerate(polynomial.monomials):
            longer = monomial if slot is None else tuple(sorted((*monomial, slot)))
            weight = polynomial.weights[:, j] * factor
            collected[longer] = collected[longer] + weight if longer in collected else weight
    keys = sorted(collected)
    return Polynomial(tuple(keys), np.stack([collected[key] for key in keys], axis=1))


def product_terms(
    polynomial: Polynomial, terms: tuple[Term, ...], coefficients: NDArray[np.floating[Any]]
) -> tuple[tuple[Term, ...], NDArray[np.floating[Any]]]:
    """Multiply the light of the last surface by what its rays met before.

    Parameters
    ----------
    polynomial : Polynomial, N rays, kept as monomials
        What they met.
    terms : tuple of Term, length K
        The light of the surface.
    coefficients : ndarray, shape (N, K)
        Its geometric coefficients.

    Returns
    -------
    terms : tuple of Term, length K'
        Products, each once, sorted.
    coefficients : ndarray, shape (N, K')
        Theirs.

    Raises
    ------
    ValueError
        If the polynomial is carried at nodes.

    References
    ----------
    Own design.
    """
    if polynomial.monomials is None:
        raise ValueError("a polynomial at nodes has no monomials")
    collected: dict[Term, NDArray[np.floating[Any]]] = {}
    for j, monomial in enumerate(polynomial.monomials):
        for k, term in enumerate(terms):
            product = Term(term.emitter, tuple(sorted((*term.slots, *monomial)))) if monomial else term
            value = polynomial.weights[:, j] * coefficients[:, k]
            collected[product] = collected[product] + value if product in collected else value
    keys = tuple(sorted(collected))
    return keys, np.stack([collected[key] for key in keys], axis=1)
