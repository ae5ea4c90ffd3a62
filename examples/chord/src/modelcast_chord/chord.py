"""Mean velocity over the window."""

from dataclasses import dataclass

import numpy as np

import modelcast

__all__ = ["Chord"]


@dataclass(frozen=True, slots=True)
class Chord(modelcast.AbstractNumpySubModel):
    """Coast from the last position at the mean velocity over the window.

    Parameters
    ----------
    samples
        Window length n, at least 2.

    Raises
    ------
    ValueError
        Where the window is shorter.
    """

    samples: int = 5

    def __post_init__(self) -> None:
        if self.samples < 2:
            raise ValueError(f"samples must be at least 2, got {self.samples}")

    @property
    def name(self) -> str:
        """Short name; the one it is registered by."""
        return "chord"

    @property
    def window(self) -> int:
        """Window length n."""
        return self.samples

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Mean velocity."""
        return ("mean_velocity_east_mps", "mean_velocity_north_mps")

    def fit_batch(self, windows: modelcast.Windows) -> np.ndarray:
        """Mean velocities, (B, 2) [m/s]."""
        moved_m = windows.positions_m[:, -1] - windows.positions_m[:, 0]
        return moved_m / ((self.samples - 1) * windows.dt_s)

    def predict_batch(self, parameters: np.ndarray, horizons_s: np.ndarray, *, dt_s: float) -> np.ndarray:
        """Coast along them, (B, H, 2) [m]."""
        return parameters[:, None, :] * horizons_s[:, None]
