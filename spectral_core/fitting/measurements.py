"""Measured spectra of one sample at several geometries.

Frame of a measurement: the normal is +Z; the light stands in the XZ plane on the side of -X, at the angle `incidence`
from the normal, so the mirror direction leans towards +X. The viewer stands at the angle `viewing` from the normal in
the half-plane that is turned by `azimuth` about the normal, from +X: ``viewing == incidence`` with ``azimuth == 0``
is the mirror direction, and a negative `viewing` is on the side of the light. `rotation` tells how far the grain of
the sample is turned from +X.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FittingError, InvalidParameterError
from ..spectra import Spectrum
from ..validation import require_choice, require_finite, require_in_range

__all__ = ["REFERENCES", "MeasurementGeometry", "Measurements"]

REFERENCES = ("diffuser", "beam")
"""What measured values are relative to: the perfect diffuser lit in the same way (Eq. 2, the radiance factor of
instruments), or the irradiance on a plane facing the light (the E of Eqs. 8 to 10)."""

_RIGHT_ANGLE = 0.5 * np.pi
_LARGEST, _SMALLEST = 1.0e6, 1.0e-9  # of the largest value: no reflectance lies beyond, and squares stay in range


def _angles(name: str, values: ArrayLike | None, count: int, limit: float) -> NDArray[np.float64]:
    angles = np.zeros(count) if values is None else np.array(require_in_range(name, values, -limit, limit, unit="rad"))
    if angles.shape != (count,):
        raise InvalidParameterError(f"{name} must have one angle for each of {count} spectra, but has {angles.shape}")
    angles.flags.writeable = False
    return angles


@dataclass(frozen=True, slots=True, eq=False)
class MeasurementGeometry:
    """Angles of M measurements, in radians, in the frame of this module.

    Parameters
    ----------
    incidence : array_like (M,)
        Angle between normal and light, from 0 to below pi/2.
    viewing : array_like (M,)
        Angle between normal and viewer, within (-pi/2, pi/2), positive on the mirror side.
    azimuth : array_like (M,), optional
        Turn of the viewing plane about the normal, within [-2 pi, 2 pi]; 0 is the plane of incidence.
    rotation : array_like (M,), optional
        Turn of the grain of the sample about the normal, within [-2 pi, 2 pi].
    """

    incidence: NDArray[np.float64]
    viewing: NDArray[np.float64]
    azimuth: NDArray[np.float64] | None = None
    rotation: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        count = np.size(self.incidence)
        incidence = _angles("incidence", self.incidence, count, _RIGHT_ANGLE)
        viewing = _angles("viewing", self.viewing, count, _RIGHT_ANGLE)
        if incidence.size and incidence.min() < 0.0:
            raise InvalidParameterError(f"incidence must be at least 0 rad, but is {incidence.min():.6g} rad")
        for name, angles in (("incidence", incidence), ("viewing", viewing)):
            if np.any(np.abs(angles) > _RIGHT_ANGLE * (1.0 - 1.0e-9)):
                raise InvalidParameterError(f"{name} must be below 90 degrees: nothing is seen or lit at the horizon")
        object.__setattr__(self, "incidence", incidence)
        object.__setattr__(self, "viewing", viewing)
        object.__setattr__(self, "azimuth", _angles("azimuth", self.azimuth, count, 4.0 * _RIGHT_ANGLE))
        object.__setattr__(self, "rotation", _angles("rotation", self.rotation, count, 4.0 * _RIGHT_ANGLE))

    @classmethod
    def from_degrees(
        cls,
        incidence: ArrayLike,
        viewing: ArrayLike,
        azimuth: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
    ) -> MeasurementGeometry:
        """Make the geometry from angles in degrees, as files and instruments state them.

        Parameters
        ----------
        incidence, viewing : array_like (M,)
            Angles in degrees, as in the class.
        azimuth, rotation : array_like (M,), optional
            Angles in degrees, as in the class.

        Returns
        -------
        MeasurementGeometry
            The same angles in radians.

        Raises
        ------
        InvalidParameterError
            If an angle lies outside its range, or the numbers of angles differ.

        References
        ----------
        Own design.
        """
        turned = [
            None if angles is None else np.radians(require_finite(name, angles))
            for name, angles in (("azimuth", azimuth), ("rotation", rotation))
        ]
        return cls(
            np.radians(require_finite("incidence", incidence)), np.radians(require_finite("viewing", viewing)), *turned
        )

    @property
    def count(self) -> int:
        """Number of measurements.

        Returns
        -------
        int
            M.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return int(self.incidence.size)

    def normal(self) -> NDArray[np.float64]:
        """Surface normals.

        Returns
        -------
        ndarray (M, 3)
            +Z, M times.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return np.tile(np.array([0.0, 0.0, 1.0]), (self.count, 1))

    def to_light(self) -> NDArray[np.float64]:
        """Give unit vectors towards the light.

        Returns
        -------
        ndarray (M, 3)
            Vectors in the plane of incidence.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 5 (L).
        """
        return np.stack([-np.sin(self.incidence), np.zeros(self.count), np.cos(self.incidence)], axis=1)

    def mirror(self) -> NDArray[np.float64]:
        """Give unit vectors of the mirror direction.

        Returns
        -------
        ndarray (M, 3)
            The light mirrored about the normal.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 5 (R_l).
        """
        return self.to_light() * np.array([-1.0, 1.0, 1.0])

    def to_viewer(self) -> NDArray[np.float64]:
        """Give unit vectors towards the viewer.

        Returns
        -------
        ndarray (M, 3)
            Vectors at the viewing angle, turned by the azimuth.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 5 (V).
        """
        assert self.azimuth is not None
        s = np.sin(self.viewing)
        return np.stack([s * np.cos(self.azimuth), s * np.sin(self.azimuth), np.cos(self.viewing)], axis=1)

    def tangent(self) -> NDArray[np.float64]:
        """Give unit vectors along the grain of the sample.

        Returns
        -------
        ndarray (M, 3)
            +X turned by the rotation.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        assert self.rotation is not None
        return np.stack([np.cos(self.rotation), np.sin(self.rotation), np.zeros(self.count)], axis=1)

    def from_mirror(self) -> NDArray[np.float64]:
        """Angles rho between the mirror direction and the viewer.

        Returns
        -------
        ndarray (M,)
            Radians, 0 to pi.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 5 (rho); the half-angle form keeps every digit near 0.
        """
        r, v = self.mirror(), self.to_viewer()
        return np.asarray(2.0 * np.arctan2(np.linalg.norm(r - v, axis=1), np.linalg.norm(r + v, axis=1)))

    def facet_incidence(self) -> NDArray[np.float64]:
        """Angles between the light and the bisector H: the incidence on the facets that mirror it to the viewer.

        Returns
        -------
        ndarray (M,)
            Radians, 0 to pi/2.

        Raises
        ------
        None.

        References
        ----------
        Tominaga 1996, Fig. 8; half the angle between L and V.
        """
        to_light, v = self.to_light(), self.to_viewer()
        return np.asarray(np.arctan2(np.linalg.norm(to_light - v, axis=1), np.linalg.norm(to_light + v, axis=1)))


@dataclass(frozen=True, slots=True, eq=False)
class Measurements:
    """M measured spectra of one sample over the same W wavelengths.

    Parameters
    ----------
    wavelengths_nm : array_like (W,)
        Strictly increasing, in nm; W >= 3.
    reflectances : array_like (M, W)
        Within 1e6, the largest at least 1e-9; 1 is the perfect diffuser (or any common scale). Noise may make values
        negative.
    geometry : MeasurementGeometry, optional
        Angles of the M spectra. Without them the spectra can be tested, but no lobe can be fitted.
    reference : {"diffuser", "beam"}
        What the values are relative to, see `REFERENCES`.
    name : str
        Name of the sample or file, for messages.
    labels : sequence of str, optional
        Names of the M spectra.
    """

    wavelengths_nm: NDArray[np.float64]
    reflectances: NDArray[np.float64]
    geometry: MeasurementGeometry | None = None
    reference: str = "diffuser"
    name: str = ""
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        label = f"measurements {self.name!r}" if self.name else "measurements"
        wavelengths = np.array(require_in_range(f"wavelengths of {label}", self.wavelengths_nm, 1.0e-3, unit="nm"))
        values = np.array(require_in_range(f"reflectances of {label}", self.reflectances, -_LARGEST, _LARGEST))
        require_choice(f"reference of {label}", self.reference, REFERENCES)
        if wavelengths.ndim != 1 or wavelengths.size < 3:
            raise FittingError(f"{label} must have at least 3 wavelengths, but has the shape {wavelengths.shape}")
        if np.any(np.diff(wavelengths) <= 0.0):
            at = int(np.flatnonzero(np.diff(wavelengths) <= 0.0)[0])
            raise InvalidParameterError(
                f"wavelengths of {label} must increase strictly: {wavelengths[at + 1]:g} nm follows "
                f"{wavelengths[at]:g} nm"
            )
        if values.ndim != 2 or values.shape[1] != wavelengths.size:
            raise InvalidParameterError(
                f"reflectances of {label} must have the shape (spectra, {wavelengths.size}), but have {values.shape}"
            )
        if values.shape[0] == 0:
            raise FittingError(f"{label} must have at least one spectrum")
        if not values.any():
            raise FittingError(f"{label} must not be zero everywhere: nothing was reflected")
        if np.abs(values).max() < _SMALLEST:
            raise FittingError(f"{label} must reach {_SMALLEST:g}, but the largest value is {np.abs(values).max():.3g}")
        if self.geometry is not None and self.geometry.count != values.shape[0]:
            raise InvalidParameterError(
                f"{label} must have one geometry for each spectrum, but has {self.geometry.count} geometries and "
                f"{values.shape[0]} spectra"
            )
        labels = tuple(str(text) for text in self.labels)
        if labels and len(labels) != values.shape[0]:
            raise InvalidParameterError(f"labels of {label} must be {values.shape[0]}, but are {len(labels)}")
        wavelengths.flags.writeable = False
        values.flags.writeable = False
        object.__setattr__(self, "wavelengths_nm", wavelengths)
        object.__setattr__(self, "reflectances", values)
        object.__setattr__(self, "labels", labels)

    @classmethod
    def from_spectra(
        cls,
        spectra: Sequence[Spectrum],
        geometry: MeasurementGeometry | None = None,
        reference: str = "diffuser",
        name: str = "",
    ) -> Measurements:
        """Gather spectra that were measured over the same wavelengths.

        Parameters
        ----------
        spectra : sequence of Spectrum
            M spectra with equal wavelengths.
        geometry, reference, name
            As in the class.

        Returns
        -------
        Measurements
            The spectra as one table.

        Raises
        ------
        FittingError
            If there is no spectrum, or the wavelengths of two of them differ.
        InvalidParameterError
            If a value breaks a rule of the class.

        References
        ----------
        Own design.
        """
        if not spectra:
            raise FittingError("measurements must have at least one spectrum")
        first = spectra[0].wavelengths_nm
        for index, spectrum in enumerate(spectra):
            if not np.array_equal(spectrum.wavelengths_nm, first):
                raise FittingError(
                    f"spectra must share their wavelengths, but spectrum {index} ({spectrum.name or 'unnamed'}) has "
                    f"{spectrum.wavelengths_nm.size} from {spectrum.wavelengths_nm[0]:g} nm and the first has "
                    f"{first.size} from {first[0]:g} nm; resample them first"
                )
        labels = tuple(s.name for s in spectra) if any(s.name for s in spectra) else ()
        return cls(first, np.stack([s.values for s in spectra]), geometry, reference, name, labels)

    @property
    def count(self) -> int:
        """Number of spectra.

        Returns
        -------
        int
            M.

        Raises
        ------
        None.

        References
        ----------
        Own design.
        """
        return int(self.reflectances.shape[0])

    def require_geometry(self, purpose: str) -> MeasurementGeometry:
        """Return the geometry, or raise when the angles are not known.

        Parameters
        ----------
        purpose : str
            What the angles are needed for, for the message.

        Returns
        -------
        MeasurementGeometry
            The geometry.

        Raises
        ------
        FittingError
            If the measurements have no geometry.

        References
        ----------
        Own design.
        """
        if self.geometry is None:
            label = f"measurements {self.name!r}" if self.name else "measurements"
            raise FittingError(f"{label} must state the angles of each spectrum for {purpose}, but has none")
        return self.geometry

    def reference_factor(self) -> NDArray[np.float64]:
        """Factor from "irradiance facing the light" (the E of Eqs. 8 to 10) to the reference of these values.

        Returns
        -------
        ndarray (M,)
            1 for "beam", 1/cos(incidence) for "diffuser".

        Raises
        ------
        FittingError
            If the reference is "diffuser" and the angles are not known.

        References
        ----------
        Tominaga 1996, Eqs. 2 and 3: the perfect diffuser sends out E cos(phi) / pi.
        """
        if self.reference == "beam":
            return np.ones(self.count)
        return 1.0 / np.cos(self.require_geometry("values relative to a diffuser").incidence)
