"""What becomes of a signal's power between two vehicles: path loss, shadowing, fading, buildings.

A `Propagation` puts the parts together. Each part may be left out. `tables` turns them into plain arrays,
once, so that a compiled loop needs no object and no logarithm for a link.
"""

from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from modelcast.channel import propagation_kernels as kernels
from modelcast.channel.path_loss import NEAREST_M, AbstractPathLoss, ManhattanNlos, WinnerB1
from modelcast.channel.propagation_kernels import PropagationTables
from modelcast.channel.random_kernels import CELLS
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.core.scientific import scientific

__all__ = ["NakagamiFading", "Propagation", "RaisedAntennas", "Shadowing", "StreetGrid"]

_LN_PER_DB = np.log(10.0) / 10.0
_SPACING_M = 0.5
_NO_NLOS, _NLOS_BY_DISTANCE, _NLOS_MANHATTAN = 0, 1, 2


def _decibels_fit(name: str, value: float) -> None:
    if not (np.isfinite(value) and value >= 0):
        raise ValueError(f"{name} must be finite and not negative, got {value}")


@dataclass(frozen=True, slots=True)
class Shadowing:
    """Log-normal shadowing of a pair of vehicles, the same in both directions, correlated along the way.

    Parameters
    ----------
    los_db, nlos_db
        Standard deviation on a line of sight and behind a building [dB].
    decorrelation_m
        Change of the pair's relative position after which the correlation is 1/e; 25 m on highways, 10 m in
        towns [m].

    Notes
    -----
    A first-order Gauss-Markov process of each pair: z' = r·z + sqrt(1 - r²)·e with r = exp(-|change| / D),
    after Gudmundson. Two cars that keep their distance keep their shadowing.

    References
    ----------
    M. Gudmundson, "Correlation model for shadow fading in mobile radio systems", 1991, DOI
    10.1049/el:19911328; deviations and distances as in 3GPP TR 36.885, A.1.4.
    """

    los_db: float = 3.0
    nlos_db: float = 4.0
    _: KW_ONLY
    decorrelation_m: float = 25.0

    def __post_init__(self) -> None:
        _decibels_fit("los_db", self.los_db)
        _decibels_fit("nlos_db", self.nlos_db)
        if not (np.isfinite(self.decorrelation_m) and self.decorrelation_m > 0):
            raise ValueError(f"decorrelation_m must be positive and finite, got {self.decorrelation_m}")

    def next_db(
        self, shadowing_db: FloatArray, moved_m: FloatArray, rng: np.random.Generator, *, los: BoolArray
    ) -> FloatArray:
        """Shadowing of pairs after their relative positions changed, (N,) [dB].

        Parameters
        ----------
        shadowing_db
            Shadowing before, (N,) [dB].
        moved_m
            Change of the relative position of each pair, (N,) [m].
        rng
            The channel's generator.
        los
            Which pairs see each other, (N,).
        """
        correlation = np.exp(-np.abs(moved_m) / self.decorrelation_m)
        sigma_db = np.where(los, self.los_db, self.nlos_db)
        fresh = rng.standard_normal(shadowing_db.shape) * sigma_db
        return correlation * shadowing_db + np.sqrt(1.0 - correlation**2) * fresh


@dataclass(frozen=True, slots=True)
class NakagamiFading:
    """Fast fading: power is gamma distributed with unit mean, its shape m falling with distance.

    Parameters
    ----------
    shapes
        m in the three ranges, near to far; 1 is Rayleigh.
    edges_m
        The two bounds between the ranges, rising [m].

    References
    ----------
    V. Taliwal et al., "Empirical determination of channel characteristics for DSRC vehicle-to-vehicle
    communication", 2004, DOI 10.1145/1023875.1023890; the values are those common in VANET studies.
    """

    shapes: tuple[float, float, float] = (3.0, 1.5, 1.0)
    edges_m: tuple[float, float] = (50.0, 150.0)

    def __post_init__(self) -> None:
        if not all(np.isfinite(shape) and shape >= 0.5 for shape in self.shapes):
            raise ValueError(f"shapes must be finite and at least 0.5, got {self.shapes}")
        if not 0 < self.edges_m[0] <= self.edges_m[1]:
            raise ValueError(f"edges_m must be positive and rising, got {self.edges_m}")

    def shape_at(self, distance_m: FloatArray) -> FloatArray:
        """Shape m by distance, any shape."""
        return np.asarray(self.shapes)[np.searchsorted(self.edges_m, distance_m, side="right")]

    def draw(self, distance_m: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Power factors with unit mean, any shape."""
        shape = self.shape_at(distance_m)
        return rng.gamma(shape) / shape

    def cells(self) -> FloatArray:
        """Mean power factor in equally probable cells, one row a range, (3, CELLS).

        The mean over a row is 1, whatever the number of cells. What is lost is the spread inside a cell.
        """
        rows = [_gamma_cells(shape) for shape in self.shapes]
        return np.stack(rows)


def _gamma_cells(shape: float) -> FloatArray:
    special = scientific("special", "fading")
    edges = np.asarray(special.gammaincinv(shape, np.arange(CELLS + 1) / CELLS), dtype=np.float64)
    partial = np.asarray(
        special.gammainc(shape + 1.0, edges), dtype=np.float64
    )  # mean up to an edge: m·P(m + 1, x), over m
    return np.asarray(np.diff(partial) * CELLS, dtype=np.float64)


def _normal_cells() -> FloatArray:
    special = scientific("special", "shadowing")
    edges = np.asarray(special.ndtri(np.arange(CELLS + 1) / CELLS), dtype=np.float64)
    density = np.asarray(np.exp(-0.5 * edges**2) / np.sqrt(2.0 * np.pi), dtype=np.float64)
    means = -np.diff(density) * CELLS
    return means / float(np.sqrt(np.mean(means**2)))


@dataclass(frozen=True, slots=True)
class StreetGrid:
    """Streets at equal distances in both directions; everything between them is buildings.

    Parameters
    ----------
    block_m
        From the middle of one street to that of the next; a street runs along east = 0 and north = 0 [m].
    street_m
        Width of a street from wall to wall [m].
    """

    block_m: float = 250.0
    street_m: float = 20.0

    def __post_init__(self) -> None:
        if not 0 < self.street_m < self.block_m:
            raise ValueError(
                f"street_m must be positive and below block_m, got {self.street_m} and {self.block_m}"
            )


@dataclass(frozen=True, slots=True)
class RaisedAntennas:
    """Stations whose antennas stand above the road, as roadside units' do: the last ones of a radio.

    Parameters
    ----------
    stations
        How many of the last stations.
    path_loss
        Median loss on a line of sight of a link of which one end is raised.
    gain_db
        What their antennas add to such a link beside that, as they hear and as they send [dB].
    """

    stations: int
    path_loss: AbstractPathLoss
    gain_db: float = 0.0

    def __post_init__(self) -> None:
        if self.stations < 1:
            raise ValueError(f"stations must be at least 1, got {self.stations}")
        if not np.isfinite(self.gain_db):
            raise ValueError(f"gain_db must be finite, got {self.gain_db}")

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """Median loss less the gain, any shape [dB]."""
        return np.asarray(self.path_loss.loss_db(distance_m) - self.gain_db, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Propagation:
    """Path loss, shadowing, fading and buildings together.

    Parameters
    ----------
    path_loss
        Median loss on a line of sight.
    shadowing, fading
        None leaves them out.
    streets
        Where buildings are; None for open ground, where everybody sees everybody.
    nlos
        Median loss behind a building; needs ``streets``. A raised antenna changes that round a corner by what
        it changes along the first street (`ManhattanNlos`), and any other by its gain alone.
    raised
        Stations with antennas above the road; None for none. `gain_db` is that of links without them.

    Examples
    --------
    >>> import numpy as np
    >>> median = Propagation(shadowing=None, fading=None)
    >>> median.gain_db(np.array([[0.0, 0.0]]), np.array([[300.0, 0.0]])).round(1).tolist()
    [-119.1]
    """

    path_loss: AbstractPathLoss = field(default_factory=WinnerB1)
    shadowing: Shadowing | None = field(default_factory=Shadowing)
    fading: NakagamiFading | None = field(default_factory=NakagamiFading)
    _: KW_ONLY
    streets: StreetGrid | None = None
    nlos: AbstractPathLoss | ManhattanNlos | None = None
    raised: RaisedAntennas | None = None

    def __post_init__(self) -> None:
        if (self.streets is None) != (self.nlos is None):
            raise ValueError("streets and nlos go together: give both or neither")

    def line_of_sight(self, from_m: FloatArray, to_m: FloatArray) -> BoolArray:
        """Which pairs of places see each other, (N,).

        Parameters
        ----------
        from_m, to_m
            East and north of both ends, (N, 2) [m].
        """
        if self.streets is None:
            everybody: BoolArray = np.ones(len(from_m), dtype=np.bool_)
            return everybody
        block_m, half_m = self.streets.block_m, 0.5 * self.streets.street_m
        first, second = np.round(from_m / block_m), np.round(to_m / block_m)
        near_first, near_second = np.abs(from_m - first * block_m), np.abs(to_m - second * block_m)
        on_street = (near_first <= half_m) & (near_second <= half_m) & (first == second)
        return np.asarray(on_street[:, 0] | on_street[:, 1], dtype=np.bool_)

    def gain_db(self, from_m: FloatArray, to_m: FloatArray) -> FloatArray:
        """Median gain of pairs of places, path loss only, never above 0, (N,) [dB]."""
        way_m = np.abs(to_m - from_m)
        distance_m = np.hypot(way_m[:, 0], way_m[:, 1])
        loss_db: FloatArray = self.path_loss.loss_db(distance_m)
        if self.nlos is not None:
            if isinstance(self.nlos, ManhattanNlos):
                behind_db = self.nlos.loss_db(way_m[:, 0], way_m[:, 1])
            else:
                behind_db = self.nlos.loss_db(distance_m)
            los = self.line_of_sight(from_m, to_m)
            loss_db = np.asarray(np.where(los, loss_db, behind_db), dtype=np.float64)
        return np.asarray(np.minimum(-loss_db, 0.0), dtype=np.float64)

    def range_m(self, loss_db: float, *, longest_m: float = 5000.0) -> float:
        """Distance from which on the median loss stays above a bound, at most ``longest_m`` [m]."""
        reach_m = np.arange(NEAREST_M, longest_m + 1.0)
        least_db = self.path_loss.loss_db(reach_m)
        if self.raised is not None:
            least_db = np.minimum(least_db, self.raised.loss_db(reach_m))
        heard = np.flatnonzero(least_db <= loss_db)
        return float(reach_m[heard[-1]]) if heard.size else NEAREST_M

    def tables(self, range_m: float) -> PropagationTables:
        """Arrays for compiled loops, good for links up to ``range_m`` [m]."""
        distance_m = np.arange(0.0, range_m + 2.0 * _SPACING_M + 1.0, _SPACING_M)
        los_ln = np.minimum(-self.path_loss.loss_db(distance_m), 0.0) * _LN_PER_DB
        kind, nlos_ln, corner_ln = _NO_NLOS, los_ln, 0.0
        if isinstance(self.nlos, ManhattanNlos):
            kind, corner_ln = _NLOS_MANHATTAN, -self.nlos.constant_db * _LN_PER_DB
            nlos_ln = -self.nlos.los.loss_db(distance_m) * _LN_PER_DB
        elif self.nlos is not None:
            kind = _NLOS_BY_DISTANCE
            nlos_ln = np.minimum(-self.nlos.loss_db(distance_m), 0.0) * _LN_PER_DB
        raised_los_ln, raised_nlos_ln = los_ln, nlos_ln
        if self.raised is not None:
            raised_los_ln = np.minimum(-self.raised.loss_db(distance_m), 0.0) * _LN_PER_DB
            raised_nlos_ln = (
                -self.raised.loss_db(distance_m) * _LN_PER_DB
                if kind == _NLOS_MANHATTAN
                else nlos_ln + self.raised.gain_db * _LN_PER_DB
            )
        shadowing = self.shadowing or Shadowing(0.0, 0.0)
        fading, edges_m = np.ones((3, 1)), (np.inf, np.inf)
        if self.fading is not None:
            fading, edges_m = self.fading.cells(), self.fading.edges_m
        streets = self.streets or StreetGrid()
        return PropagationTables(
            los_ln=los_ln,
            nlos_ln=nlos_ln,
            per_m=1.0 / _SPACING_M,
            nlos_kind=kind,
            corner_ln=corner_ln,
            block_m=streets.block_m,
            half_street_m=0.5 * streets.street_m,
            shadowing_los_ln=shadowing.los_db * _LN_PER_DB,
            shadowing_nlos_ln=shadowing.nlos_db * _LN_PER_DB,
            decorrelation_m=shadowing.decorrelation_m,
            normal=_normal_cells().astype(np.float32),
            fading=fading.astype(np.float32),
            fading_near_m=edges_m[0],
            fading_far_m=edges_m[1],
            raised=0 if self.raised is None else self.raised.stations,
            raised_los_ln=raised_los_ln,
            raised_nlos_ln=raised_nlos_ln,
            reach_ln=np.maximum.accumulate(np.maximum(los_ln, raised_los_ln)[::-1])[::-1].copy(),
        )

    def draw_gains(
        self,
        position_m: FloatArray,
        pairs: tuple[FloatArray, FloatArray],
        rng: np.random.Generator,
    ) -> FloatArray:
        """Power gains of many links with fresh shadowing and fading, by the compiled function, (N,).

        Parameters
        ----------
        position_m
            East and north of all vehicles, (V, 2) [m].
        pairs
            Index of the one and the other end of every link, (N,) each.
        rng
            Seeds the compiled generator.
        """
        span_m = float(np.max(np.ptp(position_m, axis=0))) if position_m.size else 0.0
        random = rng.integers(0, 2**63, size=1).astype(np.uint64)
        gains: FloatArray = kernels.draw_gains(
            np.ascontiguousarray(position_m, dtype=np.float64),
            np.asarray(pairs[0], dtype=np.int64),
            np.asarray(pairs[1], dtype=np.int64),
            self.tables(1.5 * span_m + 1.0),
            random,
        )
        return gains
