"""Picking vectors: whatever their order in memory, the same as numpy's own indexing."""

import numpy as np
import pytest

from spectral_core.tracing.columns import take_rows

VECTORS = np.random.default_rng(5).random((40, 3)).astype(np.float32)
ORDERS = {
    "C": VECTORS,
    "Fortran": np.asfortranarray(VECTORS),
    "part of Fortran": np.asfortranarray(np.concatenate([VECTORS, VECTORS]))[:40],
    "every other row": np.repeat(VECTORS, 2, axis=0)[::2],
    "one for all": np.broadcast_to(VECTORS[7], (40, 3)),
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("index", [[3, 3, 0, 39], [], range(40)], ids=["some", "none", "all"])
def test_rows_are_those_of_plain_indexing(order, index):
    index = np.array(index, np.int64)
    taken = take_rows(ORDERS[order], index)
    assert taken.dtype == np.float32
    np.testing.assert_array_equal(taken, ORDERS[order][index])


@pytest.mark.parametrize("order", ["C", "Fortran"])
def test_a_number_out_of_range_is_an_error(order):
    with pytest.raises(IndexError):
        take_rows(ORDERS[order], np.array([0, 40]))
