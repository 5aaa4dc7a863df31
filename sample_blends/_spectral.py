"""What the sample files say to the add-on: dichromatic materials, lamps and render settings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
from _modelling import save

from dichromatic_addon import spectrum_store
from dichromatic_addon.operators import addon_registered

__all__ = [
    "cloth",
    "metal",
    "plastic",
    "repeated_picture",
    "set_constant",
    "set_file",
    "set_lamp",
    "set_library",
    "set_woven",
    "use_dichromatic",
    "write_sample",
]

SURFACE = "Surface"


def _with_surface(name: str, node_type: str) -> bpy.types.Material:
    """Make a material with one of our surface nodes linked to its output."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # before Blender 5.0
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    output.location = (320.0, 0.0)
    node = tree.nodes.new(node_type)
    node.name = SURFACE
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def plastic(name: str, interface: float, attenuation: str, n: float) -> bpy.types.Material:
    """Make a Type I material; its body is the node's own colour until a spectrum is linked."""
    material = _with_surface(name, "DichromaticNodePlastic")
    node = material.node_tree.nodes[SURFACE]
    node.attenuation = attenuation
    node.inputs["Interface Reflectance"].default_value = interface
    node.inputs["n"].default_value = n
    return material


def metal(name: str, kind: str, beta: float, beta_across: float, mirror: float) -> bpy.types.Material:
    """Make a Type III material, rougher across its grooves than along them (radians)."""
    material = _with_surface(name, "DichromaticNodeMetal")
    node = material.node_tree.nodes[SURFACE]
    node.metal = kind
    node.anisotropic = beta_across != beta
    node.inputs["beta"].default_value = beta
    node.inputs["beta across"].default_value = beta_across
    node.inputs["Mirror"].default_value = mirror
    return material


def cloth(name: str, attenuation: str, n: float) -> bpy.types.Material:
    """Make a Type II material; both its spectra are the node's own colours until others are linked."""
    material = _with_surface(name, "DichromaticNodeCloth")
    node = material.node_tree.nodes[SURFACE]
    node.attenuation = attenuation
    node.inputs["n"].default_value = n
    return material


def _new_spectrum(material: bpy.types.Material, socket: str, source: str) -> bpy.types.Node:
    """Make a Spectrum node linked to a socket of the material's surface node."""
    tree = material.node_tree
    surface = tree.nodes[SURFACE]
    linked = sum(link.to_node == surface for link in tree.links)
    spectrum = tree.nodes.new("DichromaticNodeSpectrum")
    spectrum.location = (-300.0, -220.0 * linked)
    spectrum.label = socket
    spectrum.source = source
    tree.links.new(spectrum.outputs[0], surface.inputs[socket])
    return spectrum


def set_library(material: bpy.types.Material, socket: str, name: str) -> None:
    """Link a spectrum of the library to a socket."""
    _new_spectrum(material, socket, "LIBRARY").library_name = name


def set_woven(
    material: bpy.types.Material, socket: str, name: str, scales: tuple[float, float], weave: bpy.types.Node
) -> None:
    """Link a spectrum of the library that a picture varies between two scales: the gaps of a weave, and its threads."""
    tree = material.node_tree
    mix = tree.nodes.new("DichromaticNodeSpectrumMix")
    mix.location = (-300.0, -260.0 * sum(node.bl_idname == mix.bl_idname for node in tree.nodes))
    for end, scale in zip("AB", scales, strict=True):
        spectrum = tree.nodes.new("DichromaticNodeSpectrum")
        spectrum.location = (-640.0, mix.location.y - (140.0 if end == "B" else 0.0))
        spectrum.label = f"{socket}, {'gaps' if end == 'A' else 'threads'}"
        spectrum.source = "LIBRARY"
        spectrum.library_name = name
        spectrum.inputs["Scale"].default_value = scale
        tree.links.new(spectrum.outputs[0], mix.inputs[end])
    tree.links.new(weave.outputs["Color"], mix.inputs["Factor"])
    tree.links.new(mix.outputs[0], tree.nodes[SURFACE].inputs[socket])


def repeated_picture(material: bpy.types.Material, image: bpy.types.Image, uv_map: str, scale: float) -> bpy.types.Node:
    """Add a picture that is laid `scale` times along each side of a UV map."""
    tree = material.node_tree
    picture, mapping = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMapping")
    place = tree.nodes.new("ShaderNodeUVMap")
    place.uv_map = uv_map
    place.location, mapping.location, picture.location = (-1500.0, -300.0), (-1280.0, -300.0), (-1000.0, -300.0)
    mapping.inputs["Scale"].default_value = (scale, scale, 1.0)
    picture.image = image
    tree.links.new(place.outputs["UV"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], picture.inputs["Vector"])
    return picture


def set_constant(material: bpy.types.Material, socket: str, value: float) -> None:
    """Link the same value at every wavelength to a socket."""
    _new_spectrum(material, socket, "CONSTANT").value = value


def set_file(material: bpy.types.Material, socket: str, path: Path) -> None:
    """Link the samples of a spectrum file to a socket; the .blend keeps them, and the file's name as one beside it."""
    spectrum = _new_spectrum(material, socket, "FILE")
    spectrum.filepath = f"//{path.name}"  # which cannot be read yet: the .blend has no folder before it is saved
    spectrum_store.load_file(spectrum, str(path))
    spectrum[spectrum_store.PATH_KEY] = spectrum.filepath
    spectrum.refresh()


def set_lamp(lamp: bpy.types.Object, name: str) -> None:
    """Give a light the spectrum of a lamp of the library."""
    lamp.data.dichromatic.source = "LIBRARY"
    lamp.data.dichromatic.illuminant = name


def use_dichromatic(scene: bpy.types.Scene, adopted_white: str, samples: int = 4) -> None:
    """Choose the engine, and the lamp of the library that is to look white."""
    scene.render.engine = "DICHROMATIC"
    settings = scene.dichromatic
    settings.samples = samples
    settings.adaptation = "bradford"
    settings.white_source = "LIBRARY"
    settings.white_illuminant = adopted_white


def write_sample(otherwise: Path, build: Callable[[], None], arguments: list[str]) -> None:
    """Build a sample and write it to the file that the first argument names, or to `otherwise`."""
    path = Path(arguments[0]).resolve() if arguments else otherwise
    with addon_registered():
        build()
        save(path)
    print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")
