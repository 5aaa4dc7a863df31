"""Which reflection a term of the film stands for: the body's, the interface's, or none."""

from __future__ import annotations

from .scene_spectra import IMAGE, SceneSpectra, Term

__all__ = ["LIGHT_COMPONENTS", "component_of"]

LIGHT_COMPONENTS = ("body", "interface", "emission")


def component_of(term: Term, spectra: SceneSpectra) -> str:
    """Tell which reflection a term stands for.

    Parameters
    ----------
    term : Term
        A term of a film.
    spectra : SceneSpectra
        What its slots are.

    Returns
    -------
    str
        "body" when a body has reflected the light on its way, which happens at the last surface before mirrors only, so
        that a mirrored body stays body; "emission" when the light arrives as the world or a glowing surface emits it,
        seen directly or in mirrors whose factor is the constant 1; else "interface".

    Raises
    ------
    IndexError
        If the term points outside the spectra.

    References
    ----------
    Tominaga 1996, Eqs. 4 and 7, whose two terms the names are.
    """
    if any(spectra.slots[slot].component.startswith("body") for slot in term.slots):
        return "body"
    met = [slot for slot in term.slots if not spectra.slots[slot].component.startswith(IMAGE)]
    is_lamp = spectra.emitters[term.emitter].kind == "lamp"
    return "interface" if met or is_lamp else "emission"
