"""The three materials of the paper under one roof: plastic (Type I), cloth and paper (Type II), metal (Type III)."""

from __future__ import annotations

from .dielectrics import TypeI, TypeII
from .material import Material, spread_lobes
from .metals import GRAZING, INCIDENCES, TypeIII

__all__ = ["GRAZING", "INCIDENCES", "Material", "TypeI", "TypeII", "TypeIII", "spread_lobes"]
