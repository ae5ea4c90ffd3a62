"""From what the devices of people of one run did to their row."""

from dataclasses import replace

from modelcast.runtime.fleet.people import PeopleRun
from modelcast.station.sender import message_arrays as at
from modelcast.study.network.measure import ratio
from modelcast.study.network.people_rows import PEOPLE
from modelcast.study.network.rows import CASE_KEYS, CaseResult

__all__ = ["measure_people"]


def measure_people(result: CaseResult, run: PeopleRun, policy: str, counted_s: float) -> CaseResult:
    """Add the row of people to those of a run.

    Parameters
    ----------
    result
        Rows of the run.
    run
        What their devices did.
    policy
        What they sent by.
    counted_s
        Time counted [s].
    """
    case = result.run.picked(CASE_KEYS)
    sums = run.sent.total
    sent = float(sums[at.MESSAGES])
    row = PEOPLE.row(
        **case,
        people_policy=policy,
        people=ratio(run.person_s, counted_s),
        message_rate_hz=ratio(sent, run.person_s),
        certificate_ratio=ratio(float(sums[at.CERTIFICATES]), sent),
        frame_bytes=ratio(float(sums[at.FRAME_BYTES]), sent),
        airtime_ratio=ratio(float(sums[at.AIRTIME_S]), run.person_s),
        power_dbm=ratio(float(sums[at.POWER_DBM]), sent),
        received_rate_hz=ratio(run.received, run.person_s),
        unread_rate_hz=ratio(run.unread, run.person_s),
        far_rate_hz=ratio(run.far, run.person_s),
        read_rate_hz=ratio(run.read, run.person_s),
    )
    return replace(result, people=(row,))
