"""From Blender's evaluated scene to the core's: the one module that reads the dependency graph.

Everything is read in one walk over ``depsgraph.object_instances`` (modifiers, collection instances, particles and
geometry nodes are in it), each mesh once however often it is shown. What is approximated or left out is said in notes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ._core import core
from .camera_reading import Region, read_lens, read_region, window_from_projection
from .light_colours import read_light_colour
from .light_linking import is_linked, linked_objects
from .light_reading import read_light
from .mesh_reading import MeshArrays, corner_coordinates, read_mesh
from .nodes.images import Coordinates
from .nodes.reading import read_material
from .picture import PictureColour, picture_colour
from .properties import read_settings
from .render_passes import PassRequest, passes_of_layer
from .stereo import StereoEye, eye_window
from .world_reading import read_world

__all__ = ["ExportedScene", "export_camera", "export_scene"]

# Object types that never have faces of their own; curves, text, surfaces and metaballs are met a second time in the
# walk, as the meshes they evaluate to.
_FACELESS = frozenset({"CAMERA", "EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "CURVE", "SURFACE", "FONT", "META"})
_NOT_RENDERED = {
    "CURVES": "hair curves",
    "POINTCLOUD": "a point cloud",
    "VOLUME": "a volume",
    "GREASEPENCIL": "a grease pencil drawing",
    "GPENCIL": "a grease pencil drawing",
    "LIGHT_PROBE": "a light probe",
}


@dataclass(frozen=True, slots=True)
class ExportedScene:
    """What the renderer needs of a Blender scene.

    Attributes
    ----------
    layer : str
        Name of the view layer.
    scene : Scene
        The core's scene.
    settings : RenderSettings
        With the size of the rendered region.
    region : Region
        Where the region lies in the frame.
    colour : PictureColour
        From tristimulus values to the picture's colours.
    is_transparent : bool
        Whether the background becomes transparent (Film > Transparent).
    notes : tuple of str
        What was approximated or left out, each once.
    passes : PassRequest
        Passes of the view layer beside Combined.
    light_objects : tuple of str
        Names of the objects of the scene's lights; the core knows lights by their data, which objects may share.
    """

    layer: str
    scene: Any
    settings: Any
    region: Region
    colour: PictureColour
    is_transparent: bool
    notes: tuple[str, ...]
    passes: PassRequest = field(default_factory=PassRequest)
    light_objects: tuple[str, ...] = ()


@dataclass(slots=True)
class _Walk:
    """What the walk over the instances collects."""

    view_layer_eval: Any
    override: Any
    notes: list[str] = field(default_factory=list)
    instances: list[Any] = field(default_factory=list)
    object_indices: list[int] = field(default_factory=list)
    lights: list[Any] = field(default_factory=list)
    receivers: list[Callable[[str], bool] | None] = field(default_factory=list)  # of each light
    blockers: list[Callable[[str], bool] | None] = field(default_factory=list)  # of each light
    owners: list[str] = field(default_factory=list)  # of each instance: the object that light linking knows it by
    light_objects: list[str] = field(default_factory=list)  # of each light
    light_groups: list[str] = field(default_factory=list)
    materials: list[Any] = field(default_factory=list)
    material_names: list[str] = field(default_factory=list)
    material_indices: list[int] = field(default_factory=list)
    material_index: dict[str | None, int] = field(default_factory=dict)
    invisible: set[int] = field(default_factory=set)  # materials that show nothing
    coordinates: list[Coordinates | None] = field(default_factory=list)
    pictures: str = "read"  # how fresh the pixels of images must be
    emissions: list[Any] = field(default_factory=list)  # of each material, or None
    emission_groups: dict[int, set[str]] = field(default_factory=dict)  # light groups of objects that emit
    arrays: dict[int, MeshArrays | None] = field(default_factory=dict)
    meshes: dict[tuple[int, tuple[int, ...]], Any] = field(default_factory=dict)


def export_scene(
    depsgraph: Any,
    *,
    camera: Any = None,
    view: tuple[Any, Region] | None = None,
    stop_if_cancelled: Callable[[], None] = lambda: None,
) -> ExportedScene:
    """Read the evaluated scene.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
        Evaluated; its scene and view layer are exported.
    camera : bpy.types.Object, optional
        Camera to look through instead of the scene's.
    view : tuple of (Camera, Region), optional
        The core's camera and the size of a 3D view, instead of any camera object.
    stop_if_cancelled : callable, optional
        Asked before each object; raises when the user wants an end.

    Returns
    -------
    ExportedScene
        The scene, how to render it, and what was approximated.

    Raises
    ------
    DichromaticError
        With the name of the object, material or light and the reason, when something cannot be rendered.
    """
    scene = depsgraph.scene_eval  # animation reaches the evaluated copy alone
    view_layer = depsgraph.view_layer
    world = depsgraph.view_layer_eval.world_override or scene.world
    walk = _Walk(depsgraph.view_layer_eval, depsgraph.view_layer_eval.material_override)
    walk.pictures = "read" if view is None else "kept"  # a view answers at once; it hears of images that change
    core_camera, region = view or _camera(depsgraph, camera or scene.camera, walk.notes)
    for instance in depsgraph.object_instances:
        stop_if_cancelled()
        _visit(walk, instance)
    _note_scene_features(scene, walk.notes)
    passes = PassRequest(
        passes_of_layer(view_layer),
        _emitter_groups(world, walk),
        np.array(walk.object_indices, np.int64),
        np.array(walk.material_indices, np.int64),
    )
    settings = read_settings(scene)
    settings = replace(
        settings,
        samples=view_layer.samples or settings.samples,
        width=region.width,
        height=region.height,
        buffers=passes.buffers,
        shadow_share=passes.wants("shadow"),
        split_light=passes.splits_light,
    )
    return ExportedScene(
        layer=view_layer.name,
        scene=core.Scene(
            instances=walk.instances,
            materials=walk.materials,
            lights=_linked(walk),
            camera=core_camera,
            world=_world(world, scene, walk),
            material_names=walk.material_names,
            name=scene.name,
            emissions=walk.emissions,
        ),
        settings=settings,
        region=region,
        colour=picture_colour(scene),
        is_transparent=bool(scene.render.film_transparent),
        notes=tuple(dict.fromkeys(walk.notes)),
        passes=passes,
        light_objects=tuple(walk.light_objects),
    )


def _emitter_groups(world: Any, walk: _Walk) -> tuple[str, ...]:
    """Return the light group of each emitter of the core's scene, in its order: lights, world, materials that emit."""
    surfaces = []
    for index, emission in enumerate(walk.emissions):
        if emission is not None:
            groups = walk.emission_groups.get(index, set())
            surfaces.append(next(iter(groups)) if len(groups) == 1 else "")
    return (*walk.light_groups, "" if world is None else world.lightgroup, *surfaces)


def _linked(walk: _Walk) -> list[Any]:
    """Return the lights with the numbers of the instances that they light and that hide them, where linked."""

    def numbers(is_one: Callable[[str], bool] | None) -> frozenset[int] | None:
        return None if is_one is None else frozenset(i for i, name in enumerate(walk.owners) if is_one(name))

    return [
        replace(light, receivers=numbers(is_lit), blockers=numbers(hides))
        for light, is_lit, hides in zip(walk.lights, walk.receivers, walk.blockers, strict=True)
    ]


def _note_emission(walk: _Walk, owners: list[Any], mesh: Any) -> None:
    """Remember the light groups of an object that emits, and say what of it is not rendered."""
    for index in np.unique(mesh.material_index):
        if walk.emissions[index] is None:
            continue
        group = next((owner.lightgroup for owner in owners if owner.lightgroup), "")
        walk.emission_groups.setdefault(int(index), set()).add(group)
        if is_linked(owners[0]):
            walk.notes.append(f"light linking of '{owners[0].name}' is not rendered: its surface lights everything")


def export_camera(depsgraph: Any, camera: Any, eye: StereoEye) -> Any:
    """Return the core's camera of one eye of a stereoscopic camera object."""
    return _camera(depsgraph, camera, [], eye)[0]


def _camera(depsgraph: Any, camera: Any, notes: list[str], eye: StereoEye | None = None) -> tuple[Any, Region]:
    scene = depsgraph.scene
    if camera is None:
        raise core.SceneError(f"scene '{scene.name}' has no camera: add one, or make one active with Ctrl+Numpad 0")
    if camera.type != "CAMERA":
        raise core.SceneError(f"the active camera of scene '{scene.name}' must be a camera, but '{camera.name}' is not")
    evaluated = camera.evaluated_get(depsgraph)
    data = evaluated.data
    if data.type not in {"PERSP", "ORTHO"}:
        raise core.SceneError(f"camera '{camera.name}' must be perspective or orthographic, but is {data.type.lower()}")
    render = scene.render
    region = read_region(render)
    projection = np.array(
        evaluated.calc_matrix_camera(
            depsgraph,
            x=region.full_width,
            y=region.full_height,
            scale_x=render.pixel_aspect_x,
            scale_y=render.pixel_aspect_y,
        ),
        dtype=np.float64,
    )
    orthographic = data.type == "ORTHO"
    window = window_from_projection(projection, orthographic)
    if eye is not None:
        window = eye_window(window, data, eye)
    if data.dof.use_dof and orthographic:
        notes.append(f"depth of field of camera '{camera.name}' is not rendered: it is orthographic")
    return (
        core.Camera(
            matrix=np.array(evaluated.matrix_world if eye is None else eye.matrix, dtype=np.float64),
            window=region.crop(window),
            kind="orthographic" if orthographic else "perspective",
            clip_start=float(data.clip_start),
            clip_end=float(data.clip_end),
            **read_lens(evaluated, depsgraph),
        ),
        region,
    )


def _visit(walk: _Walk, instance: Any) -> None:
    shown = instance.show_particles if instance.particle_system is not None else instance.show_self
    if not shown:
        return
    obj = instance.object
    if obj.type == "MESH":
        _visit_mesh(walk, instance, obj)
    elif obj.type == "LIGHT":
        light = obj.data
        made = read_light(light, instance.matrix_world, read_light_colour(light, walk.notes), walk.notes)
        if made is not None:
            walk.lights.append(made)
            walk.light_objects.append(obj.name)
            walk.receivers.append(linked_objects(obj.light_linking.receiver_collection))
            walk.blockers.append(linked_objects(obj.light_linking.blocker_collection))
            owner = obj if obj.lightgroup or instance.parent is None else instance.parent
            walk.light_groups.append(owner.lightgroup)
    elif obj.type in _NOT_RENDERED:
        walk.notes.append(f"object '{obj.name}' is {_NOT_RENDERED[obj.type]}, which is not rendered")
    elif obj.type not in _FACELESS:
        walk.notes.append(f"object '{obj.name}' is of the type {obj.type}, which is not rendered")


def _visit_mesh(walk: _Walk, instance: Any, obj: Any) -> None:
    owners = [obj] if instance.parent is None else [obj, instance.parent]  # an instancer's flags hold for its instances
    seen = all(owner.visible_camera for owner in owners)
    casts = all(owner.visible_shadow for owner in owners)
    if not (seen or casts):
        return
    if any(owner.indirect_only_get(view_layer=walk.view_layer_eval) for owner in owners):
        seen = False
    mask = ""
    if any(owner.holdout_get(view_layer=walk.view_layer_eval) or owner.is_holdout for owner in owners):
        mask = "holdout"
    elif any(owner.is_shadow_catcher for owner in owners):
        mask = "shadow_catcher"
    mesh = _mesh(walk, obj)
    if mesh is None:
        return
    walk.owners.append(obj.name)
    _note_emission(walk, owners, mesh)
    walk.instances.append(
        core.Instance(
            mesh,
            np.array(instance.matrix_world, dtype=np.float64),
            name=obj.name,
            camera_visible=seen,
            shadow_visible=casts,
            mask=mask,
        )
    )
    walk.object_indices.append(obj.pass_index)


def _mesh(walk: _Walk, obj: Any) -> Any | None:
    """Return the core mesh of an object, shared by all objects with the same mesh and the same materials."""
    pointer = obj.data.as_pointer()  # stable: nothing is evaluated again during the walk
    if pointer not in walk.arrays:
        walk.arrays[pointer] = read_mesh(obj.data)
    arrays = walk.arrays[pointer]
    if arrays is None:
        return None
    slots = tuple(_material(walk, slot.material) for slot in obj.material_slots) or (_material(walk, None),)
    if walk.invisible.issuperset(slots):
        return None
    key = (pointer, slots)
    if key not in walk.meshes:
        slot_index = np.clip(arrays.slot_index, 0, len(slots) - 1)  # beyond the last slot: the last, as Blender has it
        walk.meshes[key] = core.Mesh(
            arrays.vertices,
            arrays.triangles,
            corner_normals=arrays.corner_normals,
            uv=_texture_coordinates(walk, obj, arrays, slots, slot_index),
            material_index=np.array(slots, np.int64)[slot_index],
            name=obj.name,
        )
    return walk.meshes[key]


def _texture_coordinates(
    walk: _Walk, obj: Any, arrays: MeshArrays, slots: tuple[int, ...], slot_index: np.ndarray
) -> np.ndarray | None:
    """Coordinates of the mesh's active UV map, and where a material's images want others, those."""
    result = arrays.uv
    for slot, material in enumerate(slots):
        source, here = walk.coordinates[material], slot_index == slot
        if source is None or not here.any():
            continue
        wanted = corner_coordinates(obj.data, arrays, source)
        if wanted is None:
            which = f"UV map '{source.uv_map}'" if source.uv_map else "UV map"
            name = walk.material_names[material]
            walk.notes.append(
                f"object '{obj.name}' has no {which}: the image of material '{name}' shows one colour there"
            )
            wanted = np.zeros((len(arrays.triangles), 3, 2))
        if wanted is not result:
            result = np.where(here[:, None, None], wanted, np.zeros_like(wanted) if result is None else result)
    return result


def _material(walk: _Walk, material: Any) -> int:
    """Return the index of a material in the core's scene; None is an empty slot."""
    material = walk.override or material
    key = None if material is None else material.name_full
    if key not in walk.material_index:
        reading = read_material(material, walk.pictures)
        walk.notes.extend(reading.notes)
        walk.material_index[key] = len(walk.materials)
        if reading.is_invisible:
            walk.invisible.add(len(walk.materials))
        walk.materials.append(reading.material)
        glow = reading.glow
        made = None if glow is None else core.Emission(glow.illuminant, glow.strength, name=material.name)
        walk.emissions.append(made)
        walk.coordinates.append(reading.coordinates)
        walk.material_indices.append(0 if material is None else material.pass_index)
        walk.material_names.append("(no material)" if material is None else material.name)
    return walk.material_index[key]


def _world(world: Any, scene: Any, walk: _Walk) -> Any:
    """Return the world; behind a transparent film it lights surfaces and is not seen."""
    made = read_world(world, walk.notes, walk.pictures)
    return replace(made, camera_visible=False) if scene.render.film_transparent else made


def _note_scene_features(scene: Any, notes: list[str]) -> None:
    render = scene.render
    if render.use_motion_blur:
        notes.append("motion blur is not rendered")
