"""Values every layer shares: trips, frames, errors. NumPy, Numba and pymap3d only."""
