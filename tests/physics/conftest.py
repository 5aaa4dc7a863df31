"""Directions for the tests of the reflection laws."""

import numpy as np
import pytest

from tests.core.conftest import colour

__all__ = ["colour", "unit_vectors"]


@pytest.fixture
def unit_vectors():
    """A maker of random normals, lights and viewers (N, 3), light and viewer above the surface."""

    def make(count, dtype, lowest=0.02, seed=7):
        rng = np.random.default_rng(seed)

        def directions():
            v = rng.normal(size=(4 * count + 100, 3))
            return v / np.linalg.norm(v, axis=1, keepdims=True)

        normal, light, viewer = directions(), directions(), directions()
        light *= np.sign((light * normal).sum(1))[:, None]
        viewer *= np.sign((viewer * normal).sum(1))[:, None]
        keep = np.minimum((light * normal).sum(1), (viewer * normal).sum(1)) > lowest
        chosen = [a[keep][:count].astype(dtype) for a in (normal, light, viewer)]
        assert len(chosen[0]) == count
        return chosen

    return make
