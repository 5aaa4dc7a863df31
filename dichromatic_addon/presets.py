"""Named materials that are applied to the nodes with one click; starting points, by formula or from the library."""

import math
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.props import StringProperty

from .names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE
from .nodes.editing import link_spectrum_node, set_surface_node
from .nodes.imported import forget_record

__all__ = ["CLASSES", "PRESETS", "MaterialPreset", "apply_preset", "register", "unregister"]


@dataclass(frozen=True, slots=True)
class MaterialPreset:
    """One named material.

    Attributes
    ----------
    name : str
        As the menu shows it.
    group : str
        Heading in the menu.
    node_type : str
        Identifier of the surface node.
    body : str
        Name of S_B in the library; empty for metals.
    interface : str or float
        S_I: a number for Type I, a name in the library for Type II; unused for metals.
    interface_scale : float
        Factor on a named S_I.
    attenuation : str
        f(rho).
    n : float
        Sharpness of f(rho).
    metal : str
        Name in the library, for metals.
    beta_degrees : float
        Half-value angle of the facets, for metals.
    across_degrees : float
        The same across the tangent; 0 for isotropic metals.
    """

    name: str
    group: str
    node_type: str
    body: str = ""
    interface: str | float = 0.0
    interface_scale: float = 1.0
    attenuation: str = "cosine"
    n: float = 11.0
    metal: str = ""
    beta_degrees: float = 5.0
    across_degrees: float = 0.0


def _plastic(name: str, body: str, interface: float, n: float, attenuation: str = "cosine") -> MaterialPreset:
    return MaterialPreset(name, "Plastic", PLASTIC_NODE, body, interface, attenuation=attenuation, n=n)


def _paint(name: str, body: str, interface: float, n: float, group: str = "Paint") -> MaterialPreset:
    return MaterialPreset(name, group, PLASTIC_NODE, body, interface, attenuation="gaussian", n=n)


def _cloth(name: str, body: str, interface: str, scale: float, n: float, group: str = "Cloth") -> MaterialPreset:
    return MaterialPreset(name, group, CLOTH_NODE, body, interface, scale, "exponential", n)


def _metal(name: str, metal: str, beta: float, across: float = 0.0) -> MaterialPreset:
    return MaterialPreset(name, "Metal", METAL_NODE, metal=metal, beta_degrees=beta, across_degrees=across)


PRESETS: tuple[MaterialPreset, ...] = (
    _plastic("Blue Plastic Cup", "plastic blue", 5.0, 11.0),
    _plastic("Red Plastic Cup", "plastic red", 5.0, 11.0),
    _plastic("Yellow Toy Brick", "plastic yellow", 3.0, 60.0),
    _plastic("Green Bottle Crate", "plastic green", 1.5, 10.0, "exponential"),
    _plastic("Orange Bucket", "plastic orange", 1.0, 8.0, "exponential"),
    _plastic("White Appliance", "plastic white", 2.0, 40.0),
    _plastic("Black Keyboard", "plastic black", 0.3, 6.0, "exponential"),
    _plastic("Gray Housing", "plastic grey", 0.6, 8.0, "exponential"),
    _paint("Cream Wall Paint", "paint cream", 0.05, 2.0),
    _paint("Signal Red Enamel", "paint signal red", 6.0, 150.0),
    _paint("Cobalt Blue Gloss", "paint cobalt blue", 4.0, 80.0),
    _paint("Viridian Satin", "paint viridian", 0.8, 12.0),
    _paint("Ochre Matte", "paint ochre", 0.05, 2.0),
    _paint("Oiled Oak", "wood oak", 0.4, 8.0, "Natural"),
    _paint("Terracotta", "terracotta", 0.03, 2.0, "Natural"),
    _paint("Brown Leather", "leather brown", 0.5, 10.0, "Natural"),
    _paint("Concrete", "concrete", 0.0, 1.0, "Natural"),
    _cloth("Green Rayon Satin", "satin green body", "satin green interface", 1.0, 10.0),
    _cloth("Red Rayon Satin", "satin red body", "satin red interface", 1.0, 10.0),
    _cloth("Blue Rayon Satin", "satin blue body", "satin blue interface", 1.0, 10.0),
    _cloth("White Cotton", "cotton white", "cotton white", 0.08, 3.0),
    _cloth("Raw Linen", "linen raw", "linen raw", 0.15, 3.0),
    _cloth("Indigo Denim", "denim indigo", "cotton white", 0.08, 3.0),
    _cloth("Navy Felt", "felt navy", "felt navy", 0.5, 2.0),
    _cloth("Copy Paper", "paper white", "paper white", 0.1, 4.0, "Paper"),
    _cloth("Recycled Paper", "paper recycled", "paper recycled", 0.08, 3.0, "Paper"),
    _cloth("Cyan Gloss Print", "print cyan", "paper white", 1.0, 25.0, "Paper"),
    _cloth("Magenta Gloss Print", "print magenta", "paper white", 1.0, 25.0, "Paper"),
    _cloth("Yellow Gloss Print", "print yellow", "paper white", 1.0, 25.0, "Paper"),
    _metal("Spun Copper", "copper", 5.0, 15.0),
    _metal("Copper Plate", "copper", 5.0),
    _metal("Brass", "brass-70-30", 5.0),
    _metal("Red Brass", "brass-85-15", 8.0),
    _metal("Gold", "gold", 6.0),
    _metal("Silver", "silver", 6.0),
    _metal("Brushed Aluminum", "aluminium", 6.0, 20.0),
)
"""The materials, in the order of the menu. Their spectra are the library's; gloss and roughness are chosen by eye,
except for the cups, the satin and the spun copper, which have the parameters of Tominaga 1996 (Figures 10 to 12)."""


def apply_preset(material: Any, preset: MaterialPreset) -> Any:
    """Give a material the nodes and values of a preset, and return its surface node.

    Parameters
    ----------
    material : bpy.types.Material
        An editable material.
    preset : MaterialPreset
        What it is to become.

    Returns
    -------
    bpy.types.Node
        The surface node.
    """
    node = set_surface_node(material, preset.node_type)
    forget_record(node)  # what was imported into it is no longer what it is
    if preset.node_type == METAL_NODE:
        node.source, node.metal = "LIBRARY", preset.metal
        node.anisotropic = preset.across_degrees > 0.0
        node.inputs["beta"].default_value = math.radians(preset.beta_degrees)
        if node.anisotropic:
            node.inputs["beta across"].default_value = math.radians(preset.across_degrees)
        return node
    node.attenuation = preset.attenuation
    node.inputs["n"].default_value = preset.n
    _set_spectrum(material, node, "Body Reflectance", preset.body, 1.0)
    if isinstance(preset.interface, str):
        _set_spectrum(material, node, "Interface Reflectance", preset.interface, preset.interface_scale)
    else:
        socket = node.inputs["Interface Reflectance"]
        for link in list(socket.links):
            material.node_tree.links.remove(link)
        socket.default_value = preset.interface
    return node


def _set_spectrum(material: Any, node: Any, input_name: str, name: str, scale: float) -> None:
    """Use the Spectrum node that is linked already, unless it feeds others too."""
    socket = node.inputs[input_name]
    linked = socket.links[0].from_node if socket.is_linked else None
    if linked is None or not hasattr(linked, "library_name") or len(linked.outputs[0].links) > 1:
        linked = link_spectrum_node(material.node_tree, node, input_name)
    linked.source = "LIBRARY"
    linked.library_name = name
    linked.inputs["Scale"].default_value = scale


class DICHROMATIC_OT_material_preset(bpy.types.Operator):
    bl_idname = "dichromatic.material_preset"
    bl_label = "Apply Material Preset"
    bl_description = "Give the material the nodes and values of a named material"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Preset", options={"HIDDEN"})  # type: ignore[valid-type]

    @classmethod
    def poll(cls, context: Any) -> bool:
        material = getattr(context, "material", None) or getattr(context.object, "active_material", None)
        return material is not None and material.library is None

    def execute(self, context: Any) -> set[str]:
        preset = next((preset for preset in PRESETS if preset.name == self.name), None)
        if preset is None:
            self.report({"ERROR"}, f"There is no material preset '{self.name}'")
            return {"CANCELLED"}
        material = getattr(context, "material", None) or context.object.active_material
        apply_preset(material, preset)
        return {"FINISHED"}


class DICHROMATIC_MT_material_presets(bpy.types.Menu):
    bl_idname = "DICHROMATIC_MT_material_presets"
    bl_label = "Material Presets"
    bl_description = "Named materials: plastics, paints, natural materials, cloth, paper and metals"

    def draw(self, context: Any) -> None:
        row = self.layout.row()
        column = None
        group = ""
        for preset in PRESETS:
            if preset.group != group:
                group = preset.group
                column = row.column()
                column.label(text=group)
                column.separator()
            assert column is not None
            column.operator(DICHROMATIC_OT_material_preset.bl_idname, text=preset.name).name = preset.name


CLASSES = (DICHROMATIC_OT_material_preset, DICHROMATIC_MT_material_presets)


def register() -> None:
    """Register the operator and the menu."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Take them out again."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
