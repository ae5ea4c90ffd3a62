"""What hosts of a fleet on the air warned of, by who speaks and who reads how."""

from dataclasses import KW_ONLY, dataclass

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.receiver.reading import Reading

__all__ = ["PairingScores"]


@dataclass(frozen=True, slots=True, eq=False)
class PairingScores:
    """What hosts of one reading warned of remotes of one sender, in one run: H hosts, E true warnings.

    Parameters
    ----------
    application
        Its name.
    group, reading
        Number of the sender, and how hosts read it.
    host_s
        Time that hosts were observed [s].
    counted
        Instants of pairs near the decision.
    host
        Hosts with an instant that counts or a false warning, (H,).
    negatives, false
        Their instants near the decision without a true warning, and those of them at which they warned, (H,).
    false_warnings
        Warnings with no true one near in time, however far from the decision, also of remotes that are no
        threat, (H,).
    event_host, event_remote
        Identifiers, (E,).
    event_s
        When each true warning begins, (E,) [s].
    positives, missed
        Instants of it that count, and those of them at which the host did not warn, (E,).
    delay_s
        How late the warning came, infinite where it did not, (E,) [s].
    """

    application: str
    group: int
    reading: Reading
    _: KW_ONLY
    host_s: float
    counted: int
    host: IntArray
    negatives: IntArray
    false: IntArray
    false_warnings: IntArray
    event_host: IntArray
    event_remote: IntArray
    event_s: FloatArray
    positives: IntArray
    missed: IntArray
    delay_s: FloatArray
