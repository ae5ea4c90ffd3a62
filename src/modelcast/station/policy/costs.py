"""What messages cost and how long they serve: what the cost-aware rule decides by."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import Annotated, Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.brackets import log_bracket
from modelcast.core.rules import Each, FieldError, Grid, Keys, Number, Numbers, check, check_fields

__all__ = ["CostTable"]

_MOST = 64
_COST = Number(1e-9, 1e9)
_THRESHOLD_M = Number(1e-3, 1000.0)
_LIFE_S = Number(1e-6, 1e6)
_REST_S = Number(0.0, 1e6)
_EDGE = Number(-1e6, 1e6)
_PLAIN = Keys(
    {
        "update_cost": _COST,
        "identification_cost": _COST,
        "thresholds_m": Each(_THRESHOLD_M, 1, _MOST),
        "update_life_s": Each(_LIFE_S, 1, _MOST),
        "age_edges_s": Each(_EDGE, 0, _MOST),
        "share_edges": Each(_EDGE, 0, _MOST),
        "residual_life_s": Grid(4, _REST_S, _MOST),
    }
)


@dataclass(frozen=True, slots=True, eq=False)
class CostTable:
    """Costs of both kinds of message, and the time of service that each is expected to bring.

    A sender whose sub-model in use has failed may name another that still holds, for the cost of an
    identification, or fit all anew for that of an update. In the long run updates cost ``update_cost`` over
    their mean life a second. An identification pays where its cost is lower than what updates would cost over
    the residual life of the sub-model it names.

    Parameters
    ----------
    update_cost, identification_cost
        In one unit: bytes, seconds of airtime, or 1 and 1 to count messages.
    thresholds_m
        Thresholds the tables were counted at, rising, (K,) [m].
    update_life_s
        Mean time from one update to the next, where none is named in between, (K,) [s].
    age_edges_s, share_edges
        Bounds between classes of age [s] and of the error's share of the threshold, (A - 1,) and (S - 1,).
    residual_life_s
        Mean time that a sub-model holds on which holds at that age, (K, M, A, S) [s].

    Raises
    ------
    ValueError
        Where shapes do not fit, edges do not rise, or a number is out of its range.

    Notes
    -----
    Between the thresholds tables are interpolated over the threshold's logarithm; beyond them the nearest
    serves.

    Examples
    --------
    >>> import numpy as np
    >>> table = CostTable(
    ...     60.0,
    ...     12.0,
    ...     thresholds_m=np.array([0.2]),
    ...     update_life_s=np.array([3.0]),
    ...     age_edges_s=np.array([1.0]),
    ...     share_edges=np.empty(0),
    ...     residual_life_s=np.array([[[[0.5], [0.8]]]]),
    ... )
    >>> table.pays(0.2, 0, age_s=0.4, share=0.9), table.pays(0.2, 0, age_s=2.0, share=0.9)
    (False, True)
    """

    update_cost: Annotated[float, _COST]
    identification_cost: Annotated[float, _COST]
    _: KW_ONLY
    thresholds_m: Annotated[FloatArray, Numbers(1, _THRESHOLD_M, _MOST)]
    update_life_s: Annotated[FloatArray, Numbers(1, _LIFE_S, _MOST)]
    age_edges_s: Annotated[FloatArray, Numbers(1, _EDGE, _MOST, least=0)]
    share_edges: Annotated[FloatArray, Numbers(1, _EDGE, _MOST, least=0)]
    residual_life_s: Annotated[FloatArray, Numbers(4, _REST_S, _MOST)]

    def __post_init__(self) -> None:
        check_fields(self)
        thresholds = self.thresholds_m.size
        for name in ("thresholds_m", "age_edges_s", "share_edges"):
            if not (np.diff(getattr(self, name)) > 0).all():
                raise FieldError(name, getattr(self, name), "numbers that rise")
        if self.update_life_s.shape != (thresholds,):
            raise FieldError("update_life_s", self.update_life_s, f"of shape ({thresholds},)")
        wanted = (thresholds, self.members, self.age_edges_s.size + 1, self.share_edges.size + 1)
        if self.residual_life_s.shape != wanted:
            raise FieldError("residual_life_s", self.residual_life_s, f"of shape {wanted}")

    @property
    def members(self) -> int:
        """Sub-models M that the table knows."""
        return self.residual_life_s.shape[1] if self.residual_life_s.ndim > 1 else 0

    def check_members(self, members: int) -> None:
        """Refuse a bank of another size: a compiled step would read past the end.

        Parameters
        ----------
        members
            Sub-models of the bank, one that serves only for want of another left out.

        Raises
        ------
        ValueError
            Where the table knows another number.
        """
        if members != self.members:
            raise ValueError(f"the costs were counted for {self.members} sub-models, the bank has {members}")

    def priced(self, update_cost: float, identification_cost: float) -> "CostTable":
        """The same lives at other costs.

        Parameters
        ----------
        update_cost, identification_cost
            In one unit.
        """
        return replace(self, update_cost=update_cost, identification_cost=identification_cost)

    def packed(self, threshold_m: float) -> FloatArray:
        """What `modelcast.station.policy.error_driven_kernels.step` reads.

        Parameters
        ----------
        threshold_m
            The policy's threshold [m].
        """
        thresholds_m: list[float] = self.thresholds_m.tolist()
        below, above, share = log_bracket(thresholds_m, threshold_m)
        lives_s, tables_s = self.update_life_s, self.residual_life_s
        life_s = float((1.0 - share) * lives_s[below] + share * lives_s[above])
        table_s: FloatArray = (1.0 - share) * tables_s[below] + share * tables_s[above]
        header = [
            self.identification_cost,
            self.update_cost / life_s,
            self.age_edges_s.size + 1,
            self.share_edges.size + 1,
        ]
        return np.concatenate([np.array(header), self.age_edges_s, self.share_edges, table_s.ravel()])

    def pays(self, threshold_m: float, member: int, *, age_s: float, share: float) -> bool:
        """Whether naming this sub-model is cheaper than an update.

        Parameters
        ----------
        threshold_m
            The policy's threshold [m].
        member
            Its index.
        age_s
            Time since the update it was fitted at [s].
        share
            Its error over the threshold.
        """
        header = self.packed(threshold_m)
        row = int(np.searchsorted(self.age_edges_s, age_s, side="right"))
        column = int(np.searchsorted(self.share_edges, share, side="right"))
        table_s = header[4 + self.age_edges_s.size + self.share_edges.size :].reshape(
            self.residual_life_s.shape[1:]
        )
        return bool(header[0] < header[1] * table_s[member, row, column])

    def as_plain(self) -> Mapping[str, Any]:
        """The table as plain values, for a profile."""
        return {
            "update_cost": self.update_cost,
            "identification_cost": self.identification_cost,
            "thresholds_m": self.thresholds_m.tolist(),
            "update_life_s": self.update_life_s.tolist(),
            "age_edges_s": self.age_edges_s.tolist(),
            "share_edges": self.share_edges.tolist(),
            "residual_life_s": self.residual_life_s.tolist(),
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "CostTable":
        """The table that `as_plain` described.

        Parameters
        ----------
        plain
            Plain values, as read from JSON.

        Raises
        ------
        FieldError
            Where they are none, or what they say is refused.
        """
        check(plain, _PLAIN)
        arrays = ("thresholds_m", "update_life_s", "age_edges_s", "share_edges", "residual_life_s")
        return cls(
            plain["update_cost"],
            plain["identification_cost"],
            **{name: np.array(plain[name], dtype=np.float64) for name in arrays},
        )
