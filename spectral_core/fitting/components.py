"""Interface and body curves read straight from the data, without a model of the lobe.

This is how the paper reads them off Fig. 6: S_I is the curve at the mirror angle, S_B the one far from it. Fits that
know the lobe (``material_fit``) separate the two where every measured curve is a mixture; these estimates need no law
and no angles, and show what a fit started from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import FittingError, InvalidParameterError
from .dichromatic import SpectralTests
from .measurements import Measurements
from .separable import LinearBasis, ModelTerms

__all__ = ["Components", "component_weights", "extreme_components"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Components:
    """An interface and a body curve.

    Parameters
    ----------
    wavelengths_nm : ndarray (W,)
        Wavelengths in nm.
    interface, body : ndarray (W,)
        S_I and S_B, in the unit of the data.
    interface_index, body_index : int
        The spectra they were read from; -1 for a curve that is not one of the spectra.
    """

    wavelengths_nm: Array
    interface: Array
    body: Array
    interface_index: int
    body_index: int


def extreme_components(measurements: Measurements, tests: SpectralTests) -> Components:
    """Take the two extreme curves of a data set as interface and body.

    Parameters
    ----------
    measurements : Measurements
        The data set. With angles, the curves at the smallest and at the largest angle from the mirror direction are
        taken; without, the two curves whose shapes differ most, the flatter one being the interface.
    tests : SpectralTests
        Of this data set. Where a constant lies in the span and there are no angles, the interface is that constant.

    Returns
    -------
    Components
        The curves.

    Raises
    ------
    FittingError
        If all curves are proportional, so that no two differ.

    References
    ----------
    Tominaga 1996, Fig. 6 and the text below Eq. 9.
    """
    if tests.one_dimensional:
        raise FittingError("all curves are proportional: interface and body cannot be told apart from them")
    used = np.flatnonzero(tests.used)
    values = measurements.reflectances
    if measurements.geometry is not None:
        rho = measurements.geometry.from_mirror()[used]
        inside, outside = int(used[np.argmin(rho)]), int(used[np.argmax(rho)])
        return Components(measurements.wavelengths_nm, values[inside], values[outside], inside, outside)
    length = np.linalg.norm(values[used], axis=1)
    shares = (values[used] / length[:, None]) @ tests.components.T
    # Within the plane of the two components the curves fan out: the ends of the fan are the extreme shapes.
    turn = np.arctan2(shares[:, 1], np.abs(shares[:, 0]))
    ends = used[np.argmin(turn)], used[np.argmax(turn)]
    flatness = [abs(values[i].sum()) / (np.linalg.norm(values[i]) * np.sqrt(values.shape[1])) for i in ends]
    inside, outside = (int(i) for i in (ends if flatness[0] >= flatness[1] else ends[::-1]))
    if tests.constant_in_span:
        level = np.full(values.shape[1], float(values[inside].mean()))
        return Components(measurements.wavelengths_nm, level, values[outside], -1, outside)
    return Components(measurements.wavelengths_nm, values[inside], values[outside], inside, outside)


def component_weights(measurements: Measurements, components: Components) -> tuple[Array, Array]:
    """Weights of the two curves in every spectrum, by least squares.

    Parameters
    ----------
    measurements : Measurements
        The data set.
    components : Components
        The curves, over the same wavelengths.

    Returns
    -------
    weights : ndarray (M, 2)
        c_I and c_B of each spectrum.
    residual : ndarray (M,)
        Length of what is left of each spectrum, relative to its own length.

    Raises
    ------
    InvalidParameterError
        If the wavelengths differ.

    References
    ----------
    Tominaga 1996, Eq. 4.
    """
    if not np.array_equal(components.wavelengths_nm, measurements.wavelengths_nm):
        raise InvalidParameterError("components must be over the wavelengths of the measurements")
    columns = np.stack([components.interface, components.body], axis=1)
    slopes = np.zeros((0, *columns.shape))
    values = measurements.reflectances
    basis = LinearBasis(ModelTerms(columns, slopes), np.ones((columns.shape[0], values.shape[0])))
    weights, _, residual = basis.solve(values.T)
    length = np.linalg.norm(values, axis=1)
    left = np.linalg.norm(residual, axis=0) / np.where(length > 0.0, length, 1.0)
    return weights.T, left
