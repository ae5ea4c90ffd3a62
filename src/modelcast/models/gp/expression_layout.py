"""Where the packed constants of a kernel expression hold what.

A header; a row for each leaf (code, index of its variance among the hyper-parameters or -1, index of its
shape); a row for each product (degree in time, how many leaves, which); for each hyper-parameter the bounds
of its logarithm and whether it scales with the variance of positions (3, P); then the starts of the search,
of G points: packed inverse covariances (G, n·(n+1)/2), logarithms of the determinants (G,), hyper-parameters
(G, P) and curvatures (G, P·P).

The white noise's variance is the last hyper-parameter. All are logarithms, to base e.
"""

__all__ = [
    "AT_BOUNDS",
    "AT_CURVATURES",
    "AT_DEGREES",
    "AT_DETERMINANTS",
    "AT_DT",
    "AT_INVERSES",
    "AT_LEAF_ROWS",
    "AT_LEAVES",
    "AT_PARAMETERS",
    "AT_POINTS",
    "AT_SAMPLES",
    "AT_STARTS",
    "AT_TERMS",
    "AT_TERM_ROWS",
    "HEADER",
    "LEAF_CODE",
    "LEAF_ROW",
    "LEAF_SHAPE",
    "LEAF_VARIANCE",
    "TERM_COUNT",
    "TERM_DEGREE",
    "TERM_FIRST",
    "TERM_ROW",
]

AT_SAMPLES, AT_DT, AT_LEAVES, AT_TERMS, AT_PARAMETERS, AT_DEGREES, AT_STARTS = range(7)
AT_LEAF_ROWS, AT_TERM_ROWS, AT_BOUNDS, AT_INVERSES, AT_DETERMINANTS, AT_POINTS, AT_CURVATURES = range(7, 14)
HEADER = 16

LEAF_CODE, LEAF_VARIANCE, LEAF_SHAPE, LEAF_ROW = range(4)
TERM_DEGREE, TERM_COUNT, TERM_FIRST = range(3)
TERM_ROW = 8
