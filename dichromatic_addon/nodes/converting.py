"""Conversion for good: our nodes with what was read from a foreign material; the old shaders stay for other engines."""

from __future__ import annotations

from typing import Any

from .._core import core
from ..compat import ensure_node_tree, node_tree_of
from ..names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SPECTRUM_NODE
from .closures import Glow, Tint
from .editing import link_spectrum_node, material_output
from .fallback import ForeignReading, read_viewport_colour
from .imported import keep_record, keep_spectrum
from .reading import is_ours, read_foreign

__all__ = ["convert", "is_convertible"]

OTHER_ENGINES = ("CYCLES", "EEVEE")


def is_convertible(material: Any) -> bool:
    """Whether a material may be edited and is not made of our nodes alone.

    Parameters
    ----------
    material : bpy.types.Material or None
        Any material.

    Returns
    -------
    bool
        False for linked and overridden materials, whose nodes belong to another file, and for those of grease pencil.
    """
    if material is None or material.library is not None or material.override_library is not None:
        return False
    return not material.is_grease_pencil and not is_ours(material)


def convert(material: Any) -> tuple[str, ...] | None:
    """Give a material our nodes, with what the renderer makes of its shaders now; the picture stays the same.

    Parameters
    ----------
    material : bpy.types.Material
        One that is convertible.

    Returns
    -------
    tuple of str or None
        What was approximated; None where there was nothing to convert: only light, or nothing to be seen.

    Raises
    ------
    DichromaticError
        If the material cannot be read; it is left as it was.
    """
    if node_tree_of(material) is None:
        reading = read_viewport_colour(material, "it has no nodes")
    else:
        reading = read_foreign(material)
    if reading.is_invisible or reading.joined.only_glows:
        return None
    tree = ensure_node_tree(material)
    output = material_output(tree)
    _keep_for_other_engines(tree, output)
    node = _surface_node(tree, output, reading)
    shader = node.outputs["Surface"]
    if reading.joined.glow is not None:
        shader = _with_emission(tree, node, reading.joined.glow)
    tree.links.new(shader, output.inputs["Surface"])
    tree.update_tag()
    return reading.notes


def _keep_for_other_engines(tree: Any, output: Any) -> None:
    """Link what the output shows to outputs of Cycles and EEVEE as well, where they have none."""
    if not output.inputs["Surface"].is_linked:
        return
    targets = {node.target for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"}
    for index, target in enumerate(OTHER_ENGINES):
        if target in targets:
            continue
        other = tree.nodes.new("ShaderNodeOutputMaterial")
        other.target = target
        other.label = f"{target.title() if target == 'CYCLES' else target}: as before"
        other.location = (output.location.x, output.location.y - 170 * (index + 1))
        for socket in output.inputs:
            for link in socket.links:
                tree.links.new(link.from_socket, other.inputs[socket.identifier])


def _surface_node(tree: Any, output: Any, reading: ForeignReading) -> Any:
    """Make the surface node above the old shaders."""
    joined = reading.joined
    material = joined.material
    kinds = {core.TypeI: PLASTIC_NODE, core.TypeII: CLOTH_NODE, core.TypeIII: METAL_NODE}
    node = tree.nodes.new(kinds[type(material)])
    others = [item.location.y for item in tree.nodes if item != node]
    node.location = (output.location.x - 300, max(others, default=0.0) + 350)
    node.inputs["Mirror"].default_value = material.mirror
    node.energy_conserving = material.energy_conserving
    if isinstance(material, core.TypeIII):
        provenance = core.fitting.Provenance(notes=("converted from Blender's own shader nodes",))
        keep_record(node, core.fitting.MaterialRecord(material, "converted metal", provenance))
        node.source, node.incidence = "IMPORTED", material.incidence
        node.inputs["beta"].default_value = material.beta
        return node
    assert isinstance(material, core.TypeI | core.TypeII)
    node.attenuation = material.attenuation
    node.inputs["n"].default_value = material.n
    _give_tint(tree, node, "Body Reflectance", joined.body, 1.0)
    if isinstance(material, core.TypeI):
        node.inputs["Interface Reflectance"].default_value = material.interface_reflectance
    else:
        assert joined.lobe is not None
        _give_tint(tree, node, "Interface Reflectance", joined.lobe.tint, joined.lobe.weight * joined.lobe.sharpness)
    return node


def _give_tint(tree: Any, node: Any, name: str, tint: Tint, scale: float) -> None:
    """Set an input to a colour, link it to what the old shader was linked to, or keep the samples of a spectrum."""
    if tint.source is not None and not tint.source.groups and tint.source.node.id_data == tree and scale == 1.0:
        tree.links.new(tint.source.socket, node.inputs[name])
        return
    if tint.colour is not None:
        node.inputs[name].default_value = (*tint.colour, 1.0)
        if scale != 1.0:
            spectrum = link_spectrum_node(tree, node, name)
            spectrum.inputs["Scale"].default_value = scale
        return
    spectrum = link_spectrum_node(tree, node, name)
    keep_spectrum(spectrum, tint.spectrum if scale == 1.0 else tint.spectrum.scaled(scale, name=tint.spectrum.name))
    spectrum.source = "STORED"


def _with_emission(tree: Any, node: Any, glow: Glow) -> Any:
    """Add an Emission node to a surface node, and return the output of both."""
    emission, both = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
    both.location = (node.location.x + 300, node.location.y)
    emission.location = (node.location.x, node.location.y + 180)
    if glow.colour is not None:
        strength = max(glow.colour)
        emission.inputs["Color"].default_value = (*(part / strength for part in glow.colour), 1.0)
        emission.inputs["Strength"].default_value = strength
    else:
        spectrum = tree.nodes.new(SPECTRUM_NODE)
        spectrum.location = (emission.location.x - 300, emission.location.y)
        keep_spectrum(spectrum, glow.illuminant)
        spectrum.source = "STORED"
        tree.links.new(spectrum.outputs["Spectrum"], emission.inputs["Color"])
        emission.inputs["Strength"].default_value = glow.strength
    tree.links.new(node.outputs["Surface"], both.inputs[0])
    tree.links.new(emission.outputs[0], both.inputs[1])
    return both.outputs[0]
