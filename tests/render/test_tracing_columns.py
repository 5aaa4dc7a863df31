"""Picking and multiplying vectors: whatever their order in memory and number, the same as numpy has for each."""

import numpy as np
import pytest

from spectral_core.tracing.columns import dot_rows, take_rows

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


@pytest.mark.parametrize("order", ORDERS)
def test_a_product_does_not_know_of_its_neighbours(order):
    vectors, other = ORDERS[order], VECTORS[::-1]
    together = dot_rows(vectors, other)
    alone = [dot_rows(vectors[k : k + 1], other[k : k + 1])[0] for k in range(40)]
    np.testing.assert_array_equal(together, alone)
    exact = (vectors.astype(np.float64) * other).sum(axis=1)
    np.testing.assert_allclose(
        together, exact, rtol=3 * np.finfo(np.float32).eps
    )  # up to three roundings a term, none negative


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_one_vector_for_all_counts_with_its_type(dtype):
    product = dot_rows(VECTORS, np.array([0.1, 0.2, 0.3], dtype))
    assert product.dtype == np.result_type(np.float32, dtype)
