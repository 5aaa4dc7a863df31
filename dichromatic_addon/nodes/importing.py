# mypy: disable-error-code="valid-type"
"""Import of a fitted material: from the file that ``dichromatic fit`` writes to the nodes of a material."""

from dataclasses import dataclass, field
from typing import Any

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ImportHelper

from .._core import core
from ..names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE
from .dielectric import DichromaticNodeCloth, DichromaticNodePlastic
from .editing import editable_material, link_spectrum_node, remove_unused_spectra, set_surface_node
from .imported import forget_record, keep_record, keep_spectrum
from .metal import DichromaticNodeMetal

__all__ = ["CLASSES", "apply_record"]

_RECIPES = {
    node_class.bl_idname: node_class.recipe
    for node_class in (DichromaticNodePlastic, DichromaticNodeCloth, DichromaticNodeMetal)
}


@dataclass(slots=True)
class _Wanted:
    """What a surface node is to hold."""

    node_type: str
    numbers: dict[str, float]
    settings: dict[str, Any]
    spectra: dict[str, core.Spectrum] = field(default_factory=dict)


def _wanted(material: core.TypeI | core.TypeII | core.TypeIII) -> _Wanted:
    settings: dict[str, Any] = {"energy_conserving": material.energy_conserving}
    numbers = {"Mirror": material.mirror}
    if isinstance(material, core.TypeIII):
        numbers["beta"] = material.beta
        if material.beta_across is not None:
            numbers["beta across"] = material.beta_across
        anisotropic = material.beta_across is not None
        settings |= {"source": "IMPORTED", "anisotropic": anisotropic, "incidence": material.incidence}
        return _Wanted(METAL_NODE, numbers, settings)
    numbers["n"] = material.n
    settings["attenuation"] = material.attenuation
    spectra = {"Body Reflectance": core.require_plain("body reflectance", material.body_reflectance)}
    if isinstance(material, core.TypeI):
        numbers["Interface Reflectance"] = material.interface_reflectance
        return _Wanted(PLASTIC_NODE, numbers, settings, spectra)
    spectra["Interface Reflectance"] = core.require_plain("interface reflectance", material.interface_reflectance)
    return _Wanted(CLOTH_NODE, numbers, settings, spectra)


def _require_in_range(wanted: _Wanted) -> None:
    """Refuse numbers that Blender would silently move into the range of the node's inputs."""
    ranges = {socket.name: (socket.low, socket.high) for socket in _RECIPES[wanted.node_type].inputs}
    for name, value in wanted.numbers.items():
        low, high = ranges[name]
        if not low <= value <= high:
            raise core.InvalidParameterError(
                f"{name} must lie between {low:g} and {high:g} in a node, but is {value:g}"
            )


def apply_record(material: Any, record: core.fitting.MaterialRecord) -> Any:
    """Give a material the nodes and values of an imported material; nothing is changed where that is not possible.

    Parameters
    ----------
    material : bpy.types.Material
        An editable material.
    record : MaterialRecord
        What it is to become.

    Returns
    -------
    bpy.types.Node
        The surface node, which keeps the whole record.

    Raises
    ------
    InvalidParameterError
        If a number lies outside the range of the node's inputs.
    """
    wanted = _wanted(record.material)
    _require_in_range(wanted)
    node = set_surface_node(material, wanted.node_type)
    tree = material.node_tree
    forget_record(node)
    keep_record(node, record)  # before the settings, whose callbacks read it
    for name, value in wanted.settings.items():
        setattr(node, name, value)
    for name, value in wanted.numbers.items():
        socket = node.inputs[name]
        for link in list(socket.links):
            tree.links.remove(link)
        socket.default_value = value
    for name, spectrum in wanted.spectra.items():
        source = link_spectrum_node(tree, node, name)
        keep_spectrum(source, spectrum)
        source.source = "STORED"
    remove_unused_spectra(tree)
    tree.update_tag()
    return node


class DICHROMATIC_OT_import_material(bpy.types.Operator, ImportHelper):
    """Import a fitted material."""

    bl_idname = "dichromatic.import_material"
    bl_label = "Import Fitted Material"
    bl_description = (
        "Give the material what 'dichromatic fit' found in measured spectra (material.json): its type, spectra and "
        "numbers, kept in the .blend with the evidence for them"
    )
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    material_name: StringProperty(name="Material", options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context: Any) -> bool:
        return editable_material(context) is not None

    def invoke(self, context: Any, event: Any) -> set[str]:
        self.material_name = editable_material(context).name  # the panel may show another one afterwards
        return set(ImportHelper.invoke(self, context, event))

    def execute(self, context: Any) -> set[str]:
        """Read the file, then change the material."""
        try:
            material = self._material(context)
            record = core.fitting.read_material_json(bpy.path.abspath(self.filepath))
            apply_record(material, record)
        except core.DichromaticError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"'{record.name or self.filepath}' imported into material '{material.name}'")
        return {"FINISHED"}

    def _material(self, context: Any) -> Any:
        if not self.material_name:
            return editable_material(context)
        own = (material for material in bpy.data.materials if material.library is None)
        found = next((material for material in own if material.name == self.material_name), None)
        if found is None:
            raise core.SceneError(f"there is no material '{self.material_name}' to import into")
        return found


CLASSES = (DICHROMATIC_OT_import_material,)
