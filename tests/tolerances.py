"""Every tolerance of the tests, each with its cause. Use: ``from tests.tolerances import NAME``.

A tolerance without a cause hides an error. Where two computations are the same but for rounding, the constant says how
many operations the rounding may have gone through; where they differ by method, it says which and by how much.
"""

__all__ = ["FLOAT32_ROUNDING", "FLOAT64_ROUNDING", "PICTURE_BETWEEN_VERSIONS"]

# A few dozen float64 operations in another order: about 2**5 units in the last place, 2**-52 each.
FLOAT64_ROUNDING = 1e-14

# A few dozen float32 operations in another order: about 2**4 units in the last place, 2**-23 each.
FLOAT32_ROUNDING = 2e-6

# One step of an 8-bit display: pictures of two Blender versions may differ by float32 rounding in exported matrices,
# in numpy's SIMD loops and in which side of an edge a sample falls on, but nobody may be able to see it.
PICTURE_BETWEEN_VERSIONS = 1 / 255
