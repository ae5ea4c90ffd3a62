"""Numbers by which compiled code knows the leaves of a kernel."""

__all__ = ["LINEAR", "MATERN12", "MATERN32", "MATERN52", "PERIODIC", "RATIONAL_QUADRATIC", "RBF"]

LINEAR, RBF, MATERN12, MATERN32, MATERN52, RATIONAL_QUADRATIC, PERIODIC = range(7)
