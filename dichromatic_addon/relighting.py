"""The spectra of a scene as it is now, in the slots of a render that was made before: nothing is traced for them.

Lights and materials are found by their names. What spectra cannot express (a light that grew, a surface that became
glossier) is told as a difference between the relit picture and a new render.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import bpy
import mathutils
import numpy as np

from ._core import core
from .camera_reading import read_region
from .light_colours import read_light_colour
from .light_reading import read_light
from .nodes.reading import read_material
from .picture import picture_colour
from .properties import read_settings
from .world_reading import read_world

__all__ = ["Relit", "relit_layer", "settings_differences"]

_POWERS = {"power_w", "irradiance", "strength", "name"}
_COSINES = np.array([0.0, 0.2, 0.5, 0.8])
_NOT_PICTURE = {"band_samples", "film_bytes", "observer", "grid", "seed"}


@dataclass(frozen=True, slots=True)
class Relit:
    """A render with the scene's present spectra.

    Attributes
    ----------
    finished : FinishedLayer
        The relit render and how its colours are shown.
    differences : tuple of str
        Where it departs from a new render.
    """

    finished: Any
    differences: tuple[str, ...]


def relit_layer(scene: Any, finished: Any) -> Relit:
    """Apply the present spectra, observer and adaptation of a scene to a finished layer.

    Parameters
    ----------
    scene : bpy.types.Scene
        The scene, as it is edited.
    finished : FinishedLayer
        The layer as it was rendered.

    Returns
    -------
    Relit
        Shares the film.

    Raises
    ------
    DichromaticError
        If lights or materials of the render are gone, a spectrum cannot be read, or the film cannot be relit.
    """
    render = finished.render
    differences: list[str] = []
    emitters = _emitters(scene, finished, differences)
    slots = _slots(finished, differences)
    spectra = replace(render.spectra, emitters=emitters, slots=slots)
    settings = scene.dichromatic
    if render.film.is_relightable or _differs(spectra, render.spectra) or settings.observer != render.observer:
        render = replace(render.relit(spectra), observer=settings.observer, grid=settings.grid)
    exported = replace(finished.exported, colour=picture_colour(scene))
    return Relit(replace(finished, render=render, exported=exported), tuple(differences))


def settings_differences(scene: Any, finished: Any) -> list[str]:
    """Name the render settings that were changed since a layer was rendered, as the panels have them."""
    now, then = read_settings(scene), finished.exported.settings
    region = read_region(scene.render)
    now = replace(now, width=region.width, height=region.height)
    names = [
        f.name for f in fields(now) if f.name not in _NOT_PICTURE and getattr(now, f.name) != getattr(then, f.name)
    ]
    return [name.replace("_", " ") for name in names]


def _differs(one: Any, other: Any) -> bool:
    def content(spectra: Any) -> list[Any]:
        lamps = [(e.illuminant.key, e.strength) for e in spectra.emitters]
        return [*lamps, *(slot.reflectance.key for slot in spectra.slots)]

    return content(one) != content(other)


# ---- lights


def _emitters(scene: Any, finished: Any, differences: list[str]) -> tuple[Any, ...]:
    emitters = finished.render.spectra.emitters
    lamps = [emitter for emitter in emitters if emitter.kind == "lamp"]
    world, *surfaces = emitters[len(lamps) :]
    then = {light.name: light for light in finished.exported.scene.lights}
    now: dict[str, Any] = {}
    for name in dict.fromkeys(lamp.name for lamp in lamps):
        light = bpy.data.lights.get(name)
        if light is None:
            raise core.SceneError(f"light '{name}' of the kept render is gone or has another name: render again")
        now[name] = _light(light)
        if now[name] is not None and name in then:
            _compare_lights(name, then[name], now[name], differences)
    for obj in scene.objects:
        new = obj.type == "LIGHT" and not obj.hide_render and obj.data.name not in now
        if new and _light(obj.data) is not None:
            differences.append(f"light '{obj.data.name}' was not there, or had no power, when the picture was rendered")
    relit = [
        replace(lamp, strength=0.0)
        if now[lamp.name] is None
        else replace(lamp, illuminant=now[lamp.name].illuminant, strength=now[lamp.name].strength)
        for lamp in lamps
    ]
    return (*relit, _world(scene, world, differences), *(_glowing(surface) for surface in surfaces))


def _light(light: Any) -> Any | None:
    users = (obj for obj in bpy.context.scene.objects if obj.data == light)
    matrix = next((obj.matrix_world for obj in users), mathutils.Matrix())  # its scale is that of an area light
    return read_light(light, matrix, read_light_colour(light, []), [])


def _compare_lights(name: str, then: Any, now: Any, differences: list[str]) -> None:
    if type(then) is not type(now):
        differences.append(f"light '{name}' became another kind of light")
        return
    for part in fields(now):
        # What the light's own matrix decides is watched where objects move; here it is read without one.
        values = getattr(then, part.name), getattr(now, part.name)
        if part.name not in _POWERS and isinstance(values[1], float | int | str) and values[0] != values[1]:
            differences.append(f"{part.name.replace('_', ' ')} of light '{name}' was changed")


def _world(scene: Any, then: Any, differences: list[str]) -> Any:
    world = read_world(scene.world, [], pictures="none")
    if world.strength <= 0.0 or (scene.render.film_transparent and not world.lights_surfaces):
        return replace(then, strength=0.0)
    if then.strength == 0.0:
        differences.append(f"world '{world.name}' was black when the picture was rendered")
        return then
    return replace(then, illuminant=world.illuminant, strength=world.strength)


def _glowing(then: Any) -> Any:
    """Return the light of a surface as its material gives it now."""
    material = bpy.data.materials.get(then.name)
    if material is None:
        raise core.SceneError(f"material '{then.name}' of the kept render is gone or has another name: render again")
    glow = read_material(material, pictures="none").glow
    return (
        replace(then, strength=0.0)
        if glow is None
        else replace(then, illuminant=glow.illuminant, strength=glow.strength)
    )


# ---- materials


def _slots(finished: Any, differences: list[str]) -> tuple[Any, ...]:
    exported = finished.exported.scene
    then = dict(zip(exported.material_names, exported.materials, strict=True))
    now: dict[str, dict[str, Any]] = {}
    slots = []
    for slot in finished.render.spectra.slots:
        if slot.component.startswith(core.IMAGE):
            slots.append(slot)
            continue
        if slot.material not in now:
            material = _material(slot.material)
            now[slot.material] = {s.component: s.reflectance for s in core.slots_of_material(slot.material, material)}
            if slot.material in then:
                _compare_materials(slot.material, then[slot.material], material, differences)
        if slot.component == core.MIRROR and slot.component not in now[slot.material]:
            slots.append(slot)  # it mirrors no longer, which the differences tell
            continue
        if slot.component not in now[slot.material]:
            raise core.SceneError(f"material '{slot.material}' became another kind of material: render again")
        slots.append(replace(slot, reflectance=now[slot.material][slot.component]))
    return tuple(slots)


def _material(name: str) -> Any:
    material = bpy.data.materials.get(name)
    if material is None and name != "(no material)":
        raise core.SceneError(f"material '{name}' of the kept render is gone or has another name: render again")
    return read_material(material, pictures="kept").material


def _compare_materials(name: str, then: Any, now: Any, differences: list[str]) -> None:
    if then.component_names != now.component_names:
        return  # told where the slots are filled
    for part in fields(now):
        if part.name.startswith("_") or part.name not in {f.name for f in fields(then)}:
            continue
        values = getattr(then, part.name), getattr(now, part.name)
        if part.name == "mean_reflectance":
            if not np.array_equal(*(mean.weight_of_checked(_COSINES) for mean in values)):
                differences.append(
                    f"'{name}' turns white towards grazing incidence as the metal that was rendered does"
                )
        elif (
            part.name != "interface_reflectance"
            and isinstance(values[1], float | int | str | None)
            and values[0] != values[1]
        ):
            differences.append(f"{part.name.replace('_', ' ')} of material '{name}' was changed")
    for part_then, part_now in zip(then.textures, now.textures, strict=True):
        if part_then is not None and not part_then.mixes_like(part_now):
            differences.append(f"the image of material '{name}', or how it is mixed, was changed")
    if "body" in now.component_names and now.energy_conserving:
        strongest = [float(material.reflectances[0].values.max()) for material in (then, now)]
        if strongest[0] != strongest[1]:
            differences.append(f"the strength of the interface of material '{name}' also decides where light goes")
