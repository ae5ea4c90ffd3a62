"""Which rows of a result the figures, the console and the report show first, and how they are named."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass

from modelcast.study.loss_ratios import nearest_ratio
from modelcast.study.result import POOLED, EvaluationResult
from modelcast.study.rules import FREE_MATCHED, FREE_RECEIVER, MODEL_SENDER
from modelcast.study.table import Row

__all__ = [
    "EQUAL_RATE_POLICIES",
    "REFERENCE_LABELS",
    "SAME_RATE",
    "SAME_THRESHOLD",
    "Headline",
    "detail_threshold_m",
    "evaluated_ratios",
    "headlines",
    "loss_title",
    "main_bank",
    "policy_label",
    "pooled_rate",
    "pooled_reference",
    "pooled_tracking",
    "rate_basis",
    "role_of",
    "sender_label",
    "shown_ratios",
    "thresholds_m",
    "tracking_of",
]

EQUAL_RATE_POLICIES = ("baseline-matched", "baseline-periodic")
"""The two readings of a baseline that sends as often as MBC."""

SAME_THRESHOLD = (MODEL_SENDER, FREE_RECEIVER, "baseline")
"""Roles (`role_of`) that are drawn beside each other where all run at one threshold."""

SAME_RATE = (MODEL_SENDER, FREE_MATCHED, *EQUAL_RATE_POLICIES)
"""Roles that are drawn beside each other where all send as often as the first."""

REFERENCE_LABELS = {
    "clairvoyant-1": "Known future, degree 1",
    "clairvoyant-2": "Known future, degree 2",
    "clairvoyant-3": "Known future, degree 3",
    "cam": "ETSI CAM rules",
}
"""What figures and tables call the references."""

_LABELS = {
    MODEL_SENDER: "{sender}",
    "baseline": "Baseline, same threshold",
    "baseline-matched": "Baseline, error-driven, at {sender}'s {basis} rate",
    "baseline-periodic": "Baseline, periodic, at {sender}'s {basis} rate",
    FREE_RECEIVER: "Free receiver, same threshold",
    FREE_MATCHED: "Free receiver, at {sender}'s {basis} rate",
}


@dataclass(frozen=True, slots=True)
class Headline:
    """The pooled figures of one threshold.

    Parameters
    ----------
    threshold_m
        The threshold [m].
    mbc, baseline, free
        Rate rows; None where the run has none.
    tracking
        Tracking rows by packet error ratio and role of `SAME_THRESHOLD` and `SAME_RATE`.
    """

    threshold_m: float
    mbc: Row | None
    baseline: Row | None
    _: KW_ONLY
    free: Row | None
    tracking: Mapping[tuple[float, str], Row]

    @property
    def ratio(self) -> float | None:
        """MBC's message rate over the baseline's at the same threshold."""
        return _over(self.mbc, self.baseline)

    @property
    def free_ratio(self) -> float | None:
        """MBC's message rate over that of the free receiver's sender at the same threshold."""
        return _over(self.mbc, self.free)

    def p90_m(self, ratio: float, role: str) -> float | None:
        """90th percentile of somebody's tracking error at a packet error ratio [m]; None where not run.

        Parameters
        ----------
        ratio
            Packet error ratio.
        role
            As `role_of` says.
        """
        row = self.tracking.get((ratio, role))
        return None if row is None else row.pte_p90_m

    def rate_hz(self, ratio: float, role: str) -> float | None:
        """Messages that somebody sent in the loss runs at a packet error ratio [1/s]; None where not run.

        Parameters
        ----------
        ratio
            Packet error ratio.
        role
            As `role_of` says.
        """
        row = self.tracking.get((ratio, role))
        return None if row is None else row.message_rate_hz

    @property
    def airtime_ratio(self) -> float | None:
        """Airtime of MBC over that of the baseline; None where either is missing or nothing was sent."""
        if self.mbc is None or self.baseline is None or not self.baseline.airtime_per_s > 0:
            return None
        return self.mbc.airtime_per_s / self.baseline.airtime_per_s


def thresholds_m(result: EvaluationResult) -> list[float]:
    """Return the thresholds evaluated, rising [m]."""
    return sorted({row.threshold_m for row in (*result.rates, *result.tracking)})


def detail_threshold_m(result: EvaluationResult) -> float | None:
    """Return the threshold that all detail figures show: the one asked for, else the first [m].

    Parameters
    ----------
    result
        The evaluation; None where it has no threshold.
    """
    evaluated_m = thresholds_m(result)
    asked_m = result.settings.get("detail_threshold_m")
    return asked_m if asked_m in evaluated_m else next(iter(evaluated_m), None)


def evaluated_ratios(result: EvaluationResult) -> list[float]:
    """Return the packet error ratios evaluated, rising."""
    return sorted({row.packet_error_ratio for row in result.tracking})


def shown_ratios(result: EvaluationResult) -> list[float]:
    """Return the packet error ratios that tables show: those nearest to none and to 0.4, rising.

    Parameters
    ----------
    result
        The evaluation.
    """
    ratios = evaluated_ratios(result)
    nearest = (nearest_ratio(ratios, 0.0), nearest_ratio(ratios))
    return sorted({ratio for ratio in nearest if ratio is not None})


def loss_title(result: EvaluationResult) -> str:
    """Return what sets the loss runs apart from the rate runs, for titles of tables.

    Parameters
    ----------
    result
        The evaluation.
    """
    longest_s = result.settings.get("keep_alive_s")
    lossy = any(evaluated_ratios(result))
    parts = ["losses"] if lossy else []
    parts += [] if longest_s is None else [f"a message at least every {longest_s:g} s"]
    return f"with {' and '.join(parts)}" if parts else "without loss"


def main_bank(result: EvaluationResult) -> str:
    """Return the bank that is drawn: the first one of the model-based sender's rows."""
    rows = (*result.rates, *result.tracking)
    return next((row.bank for row in rows if row.policy == result.sender), "")


def role_of(result: EvaluationResult, policy: str) -> str:
    """Return what a row's policy is drawn as: ``mbc`` for whoever sends models, else its own name.

    Parameters
    ----------
    result
        The evaluation.
    policy
        As the row names it.
    """
    return MODEL_SENDER if policy == result.sender else policy


def sender_label(result: EvaluationResult) -> str:
    """Return what people read for the model-based sender: MBC, or the name of the policy that decides.

    Parameters
    ----------
    result
        The evaluation.
    """
    return "MBC" if result.sender == MODEL_SENDER else result.sender


def rate_basis(result: EvaluationResult) -> str:
    """Return the basis of the equal-rate baselines that are drawn: ``total`` where it was run."""
    found = {row.rate_basis for row in result.tracking if row.policy in EQUAL_RATE_POLICIES}
    return "update" if "update" in found and "total" not in found else "total"


def policy_label(role: str, basis: str = "total", *, sender: str = "MBC") -> str:
    """Return the name of a policy in a legend.

    Parameters
    ----------
    role
        As `role_of` says.
    basis
        Of the equal-rate baselines.
    sender
        As `sender_label` says.

    Examples
    --------
    >>> policy_label("baseline-periodic", "update")
    "Baseline, periodic, at MBC's update rate"
    """
    return _LABELS[role].format(basis=basis, sender=sender) if role in _LABELS else role


def pooled_rate(result: EvaluationResult, policy: str, threshold_m: float) -> Row | None:
    """Return the rate row of a role (`role_of`) that pools all trips, or None."""
    rows = [
        row
        for row in result.rates
        if role_of(result, row.policy) == policy and row.threshold_m == threshold_m
    ]
    return next(iter(_of_main_bank(result, _pooled(rows))), None)


def pooled_reference(result: EvaluationResult, reference: str, threshold_m: float | None) -> Row | None:
    """Return the pooled row of a reference, None where it was not counted.

    Parameters
    ----------
    result
        The evaluation.
    reference
        Key of `REFERENCE_LABELS`.
    threshold_m
        Threshold [m]; a reference that has none serves for all.
    """
    for row in result.references:
        at_threshold = row.threshold_m is None or row.threshold_m == threshold_m
        if row.trip == POOLED and row.reference == reference and at_threshold:
            return row
    return None


def pooled_tracking(result: EvaluationResult, policy: str, threshold_m: float) -> list[Row]:
    """Return the tracking rows of a role (`role_of`) that pool all trips, by rising packet error ratio.

    Of equal-rate baselines, those on the basis `rate_basis` names.
    """
    rows = [
        row
        for row in result.tracking
        if role_of(result, row.policy) == policy and row.threshold_m == threshold_m
    ]
    return tracking_of(result, _pooled(rows))


def tracking_of(result: EvaluationResult, rows: Sequence[Row]) -> list[Row]:
    """Return those of the rows that are drawn, one for each packet error ratio, rising."""
    basis = rate_basis(result)
    rows = [row for row in rows if row.rate_basis in {None, basis}]
    by_ratio: dict[float, Row] = {}
    for row in _of_main_bank(result, rows):
        by_ratio.setdefault(row.packet_error_ratio, row)
    return [by_ratio[ratio] for ratio in sorted(by_ratio)]


def headlines(result: EvaluationResult) -> list[Headline]:
    """Return the pooled figures of every threshold, rising."""
    found: list[Headline] = []
    for threshold_m in thresholds_m(result):
        tracking = {
            (row.packet_error_ratio, role): row
            for role in dict.fromkeys((*SAME_THRESHOLD, *SAME_RATE))
            for row in pooled_tracking(result, role, threshold_m)
        }
        mbc, free, baseline = (pooled_rate(result, role, threshold_m) for role in SAME_THRESHOLD)
        found.append(Headline(threshold_m, mbc, baseline, free=free, tracking=tracking))
    return found


def _over(own: Row | None, other: Row | None) -> float | None:
    if own is None or other is None or not other.total_rate_hz > 0:
        return None
    return own.total_rate_hz / other.total_rate_hz


def _pooled(rows: Sequence[Row]) -> list[Row]:
    """Return the pooled rows; where one trip was evaluated and none was pooled, that trip's."""
    pooled = [row for row in rows if row.trip == POOLED]
    if pooled or len({row.trip for row in rows}) != 1:
        return pooled
    return list(rows)


def _of_main_bank(result: EvaluationResult, rows: Sequence[Row]) -> list[Row]:
    """Return the rows with those of the drawn bank first; MBC's rows of other banks are left out."""
    bank = main_bank(result)
    kept = [row for row in rows if row.policy != result.sender or row.bank == bank]
    return sorted(kept, key=lambda row: row.bank != bank)
