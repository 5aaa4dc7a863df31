"""Every tolerance of the tests, each with its cause. Use: ``from tests.tolerances import NAME``.

A tolerance without a cause hides an error. Where two computations are the same but for rounding, the constant says how
many operations the rounding may have gone through; where they differ by method, it says which and by how much.
"""

__all__ = ["FLOAT32_ROUNDING", "FLOAT64_ROUNDING", "PICTURE_BETWEEN_VERSIONS", "TIED_DISTANCE", "TIED_RAYS"]

# A few dozen float64 operations in another order: about 2**5 units in the last place, 2**-52 each.
FLOAT64_ROUNDING = 1e-14

# A few dozen float32 operations in another order: about 2**4 units in the last place, 2**-23 each.
FLOAT32_ROUNDING = 2e-6

# One step of an 8-bit display: pictures of two Blender versions may differ by float32 rounding in exported matrices,
# in numpy's SIMD loops and in which side of an edge a sample falls on, but nobody may be able to see it.
PICTURE_BETWEEN_VERSIONS = 1 / 255

# float32 distances to the same point along a ray, by two formulas: coordinates of scene size are rounded a few times,
# by 2**-24 each. To be multiplied by the triangle's slenderness and divided by the cosine of incidence.
TIED_DISTANCE = 1e-6

# The film in float64 against Eqs. 8-13 as printed, summed over 471 wavelengths: arccos loses 1e-8 rad near the lobe's
# peak, the metal's mean reflectance is read from a table that is exact to 1e-9, and lines meet edges alike.
FILM_AGAINST_BRUTE_FORCE = 1e-6

# Part of the pixels whose single float32 ray falls on the other side of an edge or a shadow's border.
PIXELS_THAT_ROUND_ACROSS_AN_EDGE = 1e-3

# A cubic Lagrange formula of order-1 values: four products of four factors each, with cancellation between them.
INTERPOLATED_POLYNOMIAL = 1e-13

# Planck's law in logarithms: the rounding of exp(x) is that of x, to be multiplied by the size of x.
PLANCK_ROUNDING = 1e-15

# Weighted sums of some hundred float64 terms, plain order: up to 2**9 units in the last place.
SUM_OF_HUNDREDS = 1e-13

# XYZ on a scale where white is 1, of light carried on the 16 nodes of the standard grid: quadrature.
STANDARD_GRID_COLOUR = 5e-3

# A direction in float64 is known to 2**-53 rad per component; a lobe exp(-n rho) magnifies a few of those n-fold.
LOBE_OF_FLOAT64_DIRECTIONS = 2e-15

# The largest of 90,000 sampled viewers, the nearest to the horizon 1e-6 rad from the azimuth where the supremum lies.
SAMPLED_SUPREMUM = 1e-9

# Part of the rays that pass so close to an edge that float32 projection and float32 ray casting choose different sides:
# vertices are rounded to 1e-4 of a pixel, and a picture of small triangles has about one edge a pixel.
TIED_RAYS = 1e-4

# Tristimulus values by sums of 471 float64 terms in two orders of summation, where the samples are the same.
TRISTIMULUS_SUM = 1e-9

# Weights of a Lagrange table by two formulas for the same coefficients: some hundred products, all of order 0.1.
ASTM_WEIGHTS = 1e-13

# Fresnel near total reflection rises like a square root: 2**-53 in the cosine is up to 1e-8 in the reflectance.
FRESNEL_AT_CORNERS = 2e-7

# OpticalMeanReflectance checks its table of 2048 cubics against the exact mean and holds it to 1e-9 of 1 - Sa(0).
TABLE_OF_MEAN_REFLECTANCE = 1e-9

# A standard that prints four decimals: half a unit in the last of them.
STANDARD_FOUR_DIGITS = 5.1e-5

# The product against the printed formulas in float64: arccos of a cosine near 1 loses half the digits, 1e-8 rad.
PLAIN_FORMULAS = 1e-7

# Figures of copper's locus, given to four decimals (x, y) and two (Y); the integration step of the source is not told.
PUBLISHED_XY = 5e-4
PUBLISHED_LUMINANCE = 0.2

# The product's hemisphere integrals stop when a refinement changes the result by less than 1e-5, or by default.
HEMISPHERE_QUADRATURE = 1e-6

# Two quadratures of the same smooth lobe, on panels graded in different coordinates.
ANOTHER_QUADRATURE = 1e-6

# Albedos given to two decimals.
PUBLISHED_ALBEDO = 0.005

# Blender keeps camera matrices, lens and shift in float32 (2**-24): over a frame of 100 pixels and the few products of
# a projection this is below a hundredth of a pixel.
PROJECTION_IN_PIXELS = 0.01

# Parameters fitted to data without noise: what docs/fitting.md promises. The printed equations of the test data lose
# 1e-8 rad near rho = 0 to the arc cosine, and a lobe of n = 60 changes by 6e-7 of itself over that.
FIT_OF_EXACT_DATA = 1e-6

# The tilt of the bisector from two formulas, squared over beta^2: 1e-15 rad over 0.08 rad, times alpha / beta = 10.
PRINTED_ANGLES = 1e-12

# A white card against Cycles: our colour of daylight and the uplift of tints are within a few parts in a thousand of
# Blender's RGB, and Cycles' samples of a lamp with an extent scatter by less than the rest of the percent.
EXPOSURE_AGAINST_CYCLES = 0.01

# A float that went through one of Blender's 32-bit properties and a few operations: about 2**2 units of 2**-24.
BLENDER_FLOAT = 3e-7

# The incomplete beta function: differences of log-gamma values of up to 1e5 leave 1e-11 of the share.
QUANTILE = 1e-10

# Blender's conversion between its working space and Rec.709 in float32, with matrices of about six digits.
REC709_ROUND_TRIP = 1e-5

# Delta E (CIEDE2000) of a metameric pair after one of it went through a file: float64 rounding of a 3 x 3 system whose
# condition is about 30 and of sums over 471 wavelengths, under a square root that makes 1e-12 of it 1e-6.
PAINT_OF_A_FILE = 1e-5

# Lobes with n or beta rounded to Blender's 32-bit sockets: a relative error of 6e-8 of beta is twice that times the
# exponent of the lobe, which is 28 where the lobe has fallen to the 1e-12 that ends the comparison.
COEFFICIENTS_OF_FLOAT32_PARAMETERS = 1e-5

# Blender's colour nodes: Cycles keeps curves and ramps as tables of 257 entries and works in float32.
COLOUR_NODES = 2e-3

# Cycles' blackbody is a rational fit to Planck's law in linear RGB, good to about half a percent.
BLACKBODY_FITS = 0.02

# The mean of a pattern over 4 m, by Cycles' 16 samples a pixel of a 32 x 32 picture and a few periods of the pattern,
# against the mean of its distribution as far as a bell curve or a sine describes it.
MEAN_OF_A_PATTERN = 0.05

# A picture on a surface against Cycles: its 8-bit textures stay 8-bit until they are interpolated, and its bilinear
# weights and coordinates are float32 with camera rays from within a hundredth of a pixel of the centre.
IMAGE_AGAINST_CYCLES = 5e-3

# A world with a picture of 32 x 16 beside Cycles': the edges of its bright patch, in pixels filtered by two filters.
EDGES_OF_A_PICTURE = 0.02

# Thousands of stratified directions of a smooth lamp or sky, each a shadow ray: the error falls nearly as their number.
STRATIFIED_SKY = 0.01

# Structural similarity of our pictures of Cycles scenes with Cycles': without light between surfaces, with a cosine
# lobe for GGX and an opaque stand-in for glass, shades differ and edges do not, and both are noisy. Unrelated pictures
# have less than 0.5.
SIMILAR_TO_CYCLES = 0.75

# The same scene before and after its materials became ours, on a scale from black to white: numbers of the nodes are
# rounded to 32 bits, and samples fall on the same points.
SIMILAR_TO_ITSELF = 2e-3

# Two pixels beside an edge, by 16 samples of Cycles' wide filter: in some versions one or two of 128 fall beyond it.
SAMPLES_AT_AN_EDGE = 0.02
