"""A finished render taken apart by where its light came from: partial sums over the film's terms.

The film holds every pixel as a sum of terms, each one emitter times the reflectances on the way. Any selection of terms
is therefore a picture of its own, of the same rays: the body and the interface reflection apart, or each lamp for
itself. The parts of a partition add up to the whole picture, but for rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colorimetry import observer, wavelength_grid
from .errors import InvalidParameterError
from .light_components import LIGHT_COMPONENTS, component_of
from .renderer import Render
from .scene_spectra import SceneSpectra
from .validation import require_choice

__all__ = ["LIGHT_COMPONENTS", "LightPart", "component_of", "split_light"]

_PARTS_AT_ONCE = 4  # pictures that are summed in one walk over the film


@dataclass(frozen=True, slots=True)
class LightPart:
    """Which light a partial picture holds.

    Attributes
    ----------
    component : str or None
        "body", "interface" or "emission", as :func:`component_of` has them; all when None.
    lights : tuple of str or int, or None
        Names or indices of ``SceneSpectra.emitters``; all when None. A name stands for every emitter that bears it.

    Raises
    ------
    InvalidParameterError
        If there is no such component.
    """

    component: str | None = None
    lights: tuple[str | int, ...] | None = None

    def __post_init__(self) -> None:
        if self.component is not None:
            require_choice("component", self.component, LIGHT_COMPONENTS)
        if self.lights is not None:
            if isinstance(self.lights, str):
                raise InvalidParameterError(f"lights must be a sequence of names, but is the text '{self.lights}'")
            object.__setattr__(self, "lights", tuple(self.lights))


def split_light(render: Render, parts: Sequence[LightPart]) -> list[NDArray[np.floating[Any]]]:
    """Give the pictures of some parts of a render's light; no ray is traced.

    Parameters
    ----------
    render : Render
        A render whose light is kept by terms, relit ones as well; or whose settings asked to ``split_light``.
    parts : sequence of LightPart
        What each picture is to hold. Parts may overlap.

    Returns
    -------
    list of ndarray, shape (height, width, 3)
        X, Y, Z of each part, on the scale of ``Render.tristimulus``.

    Raises
    ------
    InvalidParameterError
        If the render did neither, or a light is not there.

    References
    ----------
    Own design; linearity of light.
    """
    film, spectra = render.film, render.spectra
    if not film.is_relightable and not film.fixed_parts:
        raise InvalidParameterError(
            "this render did not keep all its light by terms (deep mirrors, or the memory limit), so its light cannot "
            "be split; with split_light in the settings it could"
        )
    terms = film.terms
    table = spectra.tristimulus_table(terms, observer(render.observer), wavelength_grid(render.grid))
    components = np.array([component_of(term, spectra) for term in terms])
    emitters = np.array([term.emitter for term in terms], np.int64)
    chosen = np.ones((len(parts), len(terms)), bool)
    for row, part in zip(chosen, parts, strict=True):
        if part.component is not None:
            row &= components == part.component
        if part.lights is not None:
            row &= np.isin(emitters, _emitter_indices(part.lights, spectra))
    pictures: list[NDArray[np.floating[Any]]] = []
    for start in range(0, len(parts), _PARTS_AT_ONCE):
        some = chosen[start : start + _PARTS_AT_ONCE]
        columns = np.concatenate([table * row[:, None] for row in some], axis=1)
        sums = film.weighted_sum(columns, terms)
        pictures += [np.ascontiguousarray(sums[..., 3 * i : 3 * i + 3]) for i in range(len(some))]
    for (component, emitter), image in film.fixed_parts.items():
        for part, picture in zip(parts, pictures, strict=True):
            if part.component not in (None, component):
                continue
            if part.lights is None or emitter in _emitter_indices(part.lights, spectra):
                picture += image
    return pictures


def _emitter_indices(lights: tuple[str | int, ...], spectra: SceneSpectra) -> list[int]:
    found: list[int] = []
    for light in lights:
        if isinstance(light, str):
            hits = [i for i, emitter in enumerate(spectra.emitters) if emitter.name == light]
        else:
            hits = [light] if 0 <= light < len(spectra.emitters) else []
        if not hits:
            known = ", ".join(f"'{emitter.name}'" for emitter in spectra.emitters)
            raise InvalidParameterError(f"no light is named or numbered {light!r}; the render has {known}")
        found += hits
    return found
