"""From one of our surface nodes to a material of the core."""

from __future__ import annotations

from typing import Any

from .._core import core
from ..names import CLOTH_NODE, PLASTIC_NODE
from .imported import imported_metal
from .inputs import InputReader
from .links import Origin

__all__ = ["read_surface_node"]


def read_surface_node(origin: Origin, reader: InputReader) -> core.Material:
    """Read a Plastic, Cloth/Paper or Metal node.

    Parameters
    ----------
    origin : Origin
        The node's output.
    reader : InputReader
        Reads its inputs.

    Returns
    -------
    Material
        Type I, II or III of the core.

    Raises
    ------
    SceneError
        If the node cannot be read; the message names the node, the material and the reason.
    """
    node, groups = origin.node, origin.groups
    try:
        if node.bl_idname == PLASTIC_NODE:
            return core.TypeI(
                body_reflectance=reader.reflectance(node, "Body Reflectance", groups),
                interface_reflectance=reader.number(node, "Interface Reflectance", groups),
                attenuation=node.attenuation,
                n=reader.number(node, "n", groups),
                mirror=reader.number(node, "Mirror", groups),
                energy_conserving=node.energy_conserving,
            )
        if node.bl_idname == CLOTH_NODE:
            return core.TypeII(
                body_reflectance=reader.reflectance(node, "Body Reflectance", groups),
                interface_reflectance=reader.reflectance(node, "Interface Reflectance", groups),
                attenuation=node.attenuation,
                n=reader.number(node, "n", groups),
                mirror=reader.number(node, "Mirror", groups),
                energy_conserving=node.energy_conserving,
            )
        return _read_metal(origin, reader)
    except core.SceneError:
        raise  # names the node already
    except core.DichromaticError as error:
        raise core.SceneError(f"{reader.place(node)}: {error}") from error


def _read_metal(origin: Origin, reader: InputReader) -> core.TypeIII:
    node, groups = origin.node, origin.groups
    numbers: dict[str, Any] = {
        "beta": reader.number(node, "beta", groups),
        "beta_across": reader.number(node, "beta across", groups) if node.anisotropic else None,
        "incidence": node.incidence,
        "energy_conserving": node.energy_conserving,
        "mirror": reader.number(node, "Mirror", groups),
    }
    if node.source == "IMPORTED":
        metal = imported_metal(node)
        return core.TypeIII(metal.normal_reflectance, metal.mean_reflectance, **numbers)
    return core.TypeIII.from_optical_constants(core.optical_constants(node.metal), **numbers)
