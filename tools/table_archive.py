"""Write a table archive (npz) that has the same bytes every time, and the provenance file beside it."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import numpy as np


def write_archive(path: Path, tables: dict[str, np.ndarray]) -> None:
    """Write float64 tables as a compressed npz without time stamps (numpy.savez stamps the present time)."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, array in tables.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.ascontiguousarray(array, dtype="<f8"), version=(1, 0))
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, buffer.getvalue())


def write_provenance(path: Path, about: str, tables: dict[str, dict[str, object]]) -> None:
    """Write the JSON file that tells where every table of an archive comes from."""
    document = {"about": about, "tables": tables}
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
