"""The scene: data only, checked when it is made, and never changed afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from .buffers import BUFFERS
from .colorimetry import GRID_PRESETS, OBSERVERS
from .errors import InvalidParameterError, SceneError
from .lights import EnvironmentImage, Light, require_strength
from .reflection.materials import Material
from .spectra import Spectrum
from .tracing.camera import Camera
from .tracing.mesh import Instance
from .tracing.sampling import PIXEL_FILTERS
from .validation import require_choice, require_in_range, require_integer

__all__ = ["Emission", "RenderSettings", "Scene", "World"]

PRECISIONS = ("float32", "float64")
LARGEST_PICTURE = 2**31 - 1  # pixels; the film numbers them with 32 bits
BOUNCE_SPECTRA = ("auto", "terms", "nodes")
MOST_THREADS = 1024
_KINDS: dict[object, str] = {Material: "material", Light: "light", Instance: "instance"}


@dataclass(frozen=True, slots=True)
class World:
    """What the camera sees where it meets no surface.

    Attributes
    ----------
    illuminant : Spectrum
        Relative spectral power distribution; brought to Y = 1. The colours of an image tint it.
    strength : float
        Radiance in units of a perfect diffuser under an irradiance of pi: 1 is display white, 0 is black.
    name : str
        Shown in the plan, and the handle for relighting.
    lights_surfaces : bool
        Whether surfaces receive its light, too.
    image : EnvironmentImage, optional
        What it looks like; the same in every direction when left out.
    camera_visible : bool
        Whether the camera sees it directly; mirrors show it, and surfaces receive its light, all the same.

    Raises
    ------
    InvalidParameterError
        If a value breaks its rule.
    """

    illuminant: Spectrum = field(default_factory=lambda: Spectrum.constant(1.0, name="E"))
    strength: float = 0.0
    name: str = "World"
    lights_surfaces: bool = False
    image: EnvironmentImage | None = None
    camera_visible: bool = True

    def __post_init__(self) -> None:
        if self.image is not None and not isinstance(self.image, EnvironmentImage):
            raise InvalidParameterError(f"image of world '{self.name}' must be an EnvironmentImage")
        if not isinstance(self.illuminant, Spectrum):
            raise InvalidParameterError(f"illuminant of world '{self.name}' must be a Spectrum")
        require_strength(f"strength of world '{self.name}'", self.strength)


@dataclass(frozen=True, slots=True)
class Emission:
    """Light that a surface sends out by itself, evenly in all directions and from both sides.

    Attributes
    ----------
    illuminant : Spectrum
        Relative spectral power distribution; brought to Y = 1.
    strength : float
        Radiance in units of a perfect diffuser under an irradiance of pi: 1 is display white, 0 is dark.
    name : str
        Shown in the plan, and the handle for relighting.
    lights_surfaces : bool
        Whether other surfaces receive its light, too.

    Raises
    ------
    InvalidParameterError
        If a value breaks its rule.
    """

    illuminant: Spectrum
    strength: float
    name: str = "Emission"
    lights_surfaces: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.illuminant, Spectrum):
            raise InvalidParameterError(f"illuminant of emission '{self.name}' must be a Spectrum")
        require_strength(f"strength of emission '{self.name}'", self.strength)


@dataclass(frozen=True, slots=True)
class Scene:
    """Everything that light depends on.

    Attributes
    ----------
    instances : sequence of Instance
        Meshes with their place in the world; may be empty.
    materials : sequence of Material
        What the material indices of the instances point to.
    lights : sequence of Light
        Point, spot, sun and area lights; may be empty.
    camera : Camera or None
        Needed to render; None is refused there and not here, so that a scene can be inspected.
    world : World
        The background.
    emissions : sequence of Emission or None, optional
        What each material sends out by itself, besides what it reflects; nothing when left out.
    material_names : sequence of str, optional
        One name per material, for the plan and for relighting; numbered when left out.
    name : str
        Shown in the statistics.

    Raises
    ------
    SceneError
        If a mesh asks for a material that is not there, names and materials differ in number, or a thing is of
        another kind.
    """

    instances: Sequence[Instance] = ()
    materials: Sequence[Material] = ()
    lights: Sequence[Light] = ()
    camera: Camera | None = None
    world: World = field(default_factory=World)
    material_names: Sequence[str] = ()
    name: str = "Scene"
    emissions: Sequence[Emission | None] = ()

    def __post_init__(self) -> None:
        for attribute in ("instances", "materials", "lights", "emissions"):
            object.__setattr__(self, attribute, tuple(getattr(self, attribute)))
        for kind, things in ((Material, self.materials), (Light, self.lights), (Instance, self.instances)):
            for thing in things:
                if not isinstance(thing, kind):
                    raise SceneError(f"scene '{self.name}' holds {thing!r}, which is no {_KINDS[kind]}")
        names = tuple(self.material_names) or tuple(f"Material {i + 1}" for i in range(len(self.materials)))
        object.__setattr__(self, "material_names", names)
        if len(names) != len(self.materials):
            raise SceneError(f"scene '{self.name}' has {len(self.materials)} materials but {len(names)} material names")
        if self.emissions and len(self.emissions) != len(self.materials):
            raise SceneError(
                f"scene '{self.name}' has {len(self.materials)} materials but {len(self.emissions)} emissions"
            )
        for emission in self.emissions:
            if not (emission is None or isinstance(emission, Emission)):
                raise SceneError(f"scene '{self.name}' holds {emission!r}, which is no emission")
        for instance in self.instances:
            indices = instance.mesh.material_index
            highest = 0 if indices is None or not len(indices) else int(indices.max())
            if len(instance.mesh.triangles) and highest >= len(self.materials):
                raise SceneError(
                    f"mesh '{instance.mesh.name}' uses material index {highest}, "
                    f"but the scene has {len(self.materials)} materials"
                )


@dataclass(frozen=True, slots=True)
class RenderSettings:
    """How a scene is rendered.

    Attributes
    ----------
    width, height : int
        Size of the image in pixels, at least 1; together at most 2147483647 pixels.
    samples : int
        Rays a pixel, at least 1; the same sub-pixel positions in every pixel.
    adaptive_threshold : float
        0: every pixel takes all samples. Above: a pixel takes `min_samples` of them, and the others only if the two
        halves of these differ by more than this, in it or a neighbour (CIE 1976 Lab, the lights' own white). 1 can
        just be seen.
    min_samples : int
        Samples that every pixel takes when the others depend on them, at least 2 and made even.
    pixel_filter : str
        One of ``tracing.sampling.PIXEL_FILTERS``.
    filter_width : float
        Width of the filter in pixels, above 0.
    seed : int
        Equal seeds give equal images, bit by bit.
    observer : str
        One of ``colorimetry.OBSERVERS``.
    grid : str
        Wavelength grid of the colour side, one of ``colorimetry.GRID_PRESETS``; for direct light "exact" costs nothing.
    max_bounces : int
        How often light may be mirrored between the last lit surface and the camera; only materials with a `mirror`
        above 0 do so. At least 0.
    bounce_spectra : str
        "terms": mirrored light is kept as products of spectra, exact at any grid, whatever their number. "nodes": it is
        carried at the wavelengths of `bounce_grid`. "auto": as terms up to `term_limit`, beyond that at nodes.
    bounce_grid : str
        Wavelengths of mirrored light that is carried at nodes, one of ``colorimetry.GRID_PRESETS``.
    term_limit : int
        Longest list of terms a pixel may have in "auto", at least 1.
    precision : str
        "float32" for the bulk of the geometry, or "float64" throughout for reference renders.
    band_samples : int
        Upper bound of rays that are in memory at once; the image is worked off in bands of whole rows.
    buffers : tuple of str
        What is kept of the first surface behind each pixel, besides its depth: of ``buffers.BUFFERS``.
    split_light : bool
        Whether light that is not kept by terms (deep mirrors, or beyond the memory limit) is kept apart by component
        and emitter, so that :func:`~spectral_core.light_groups.split_light` works on any render.
    shadow_share : bool
        Whether the film keeps the share of the lamps' light that shadows take from the first surface.
    threads : int
        Threads that work side by side; 0 for one on each processor. The picture does not depend on it.
    film_bytes : int or None
        Memory that the film may take; beyond it the render keeps plain colour and cannot be relit. None for no limit.

    Raises
    ------
    InvalidParameterError
        If a value breaks its rule.
    """

    width: int = 960
    height: int = 540
    samples: int = 4
    pixel_filter: str = "blackman_harris"
    filter_width: float = 1.5
    seed: int = 0
    observer: str = "cie_1931_2"
    grid: str = "exact"
    max_bounces: int = 4
    bounce_spectra: str = "auto"
    bounce_grid: str = "standard"
    term_limit: int = 128
    precision: str = "float32"
    band_samples: int = 1 << 18
    film_bytes: int | None = 1 << 30
    adaptive_threshold: float = 0.0
    min_samples: int = 4
    buffers: tuple[str, ...] = ()
    threads: int = 0
    shadow_share: bool = False
    split_light: bool = False

    def __post_init__(self) -> None:
        require_integer("width", self.width, 1)
        require_integer("height", self.height, 1)
        require_integer("width x height", self.width * self.height, 1, LARGEST_PICTURE)
        require_integer("samples", self.samples, 1)
        require_choice("pixel_filter", self.pixel_filter, PIXEL_FILTERS)
        require_in_range("filter_width", self.filter_width, 1e-3, 16.0, unit="pixels")
        require_integer("seed", self.seed, 0)
        require_choice("observer", self.observer, OBSERVERS)
        require_choice("grid", self.grid, GRID_PRESETS)
        require_integer("max_bounces", self.max_bounces, 0)
        require_choice("bounce_spectra", self.bounce_spectra, BOUNCE_SPECTRA)
        require_choice("bounce_grid", self.bounce_grid, GRID_PRESETS)
        require_integer("term_limit", self.term_limit, 1)
        require_choice("precision", self.precision, PRECISIONS)
        require_integer("band_samples", self.band_samples, 1)
        if self.film_bytes is not None:
            require_integer("film_bytes", self.film_bytes, 0)
        require_in_range("adaptive_threshold", self.adaptive_threshold, 0.0, 1e6)
        require_integer("min_samples", self.min_samples, 2)
        object.__setattr__(self, "buffers", tuple(self.buffers))
        for name in self.buffers:
            require_choice("buffers", name, BUFFERS)
        require_integer("threads", self.threads, 0, MOST_THREADS)
