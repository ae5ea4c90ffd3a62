"""Find out what the local dynamic map costs: predicting all remotes, and hearing 1,000 messages.

The first is compared with one batched `Bank.predict_at` of the same rows. The second is asked in processor
time with plausibility, at several numbers of remotes, for messages of remotes known and of new ones.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from measured import record
from modelcast.channel.frame_radio import copied
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.models.base import Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.profile import default_profile
from modelcast.station.receiver.heard import Heard, HeardKind
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt
from modelcast.station.receiver.plausibility import Plausibility

ROUNDS = 15
MESSAGES = 1000
REMOTES = (100, 1000, 10_000)
DT_S = 0.1


def main() -> int:
    """Measure and print."""
    default = default_profile().bank.carried()
    hybrid = Bank((GaussianProcess(form="intercept"), ConstantVelocity()), "gp-intercept+cv")
    banks = {"cv": Bank((ConstantVelocity(),)), "gp-intercept+cv": hybrid, "default": default}
    for name, bank in banks.items():
        predict(name, bank)
    for name, bank in banks.items():
        for remotes in REMOTES:
            hear(name, bank, remotes)
    return 0


def predict(name: str, bank: Bank) -> None:
    """Print what all remotes cost, against one batched prediction."""
    around = LocalDynamicMap((bank,), capacity=MESSAGES)
    heard = messages(bank, np.arange(MESSAGES), 0.0)
    _, state = around.hear(around.init(), heard)
    rows = np.column_stack([heard.in_use, heard.parameters])
    ages_s = np.full(MESSAGES, 1.3)
    batched = least_ms(lambda: bank.predict_at(rows, ages_s, dt_s=DT_S))
    places = least_ms(lambda: around.positions(state, 1.3))
    all_of_it = least_ms(lambda: around.believe(state, 1.3))
    record(f"places of {MESSAGES} remotes, {name}", places, "ms", peer=("one batched prediction", batched))
    print(
        f"{name}: {MESSAGES} remotes: predict_at {batched:.3f} ms, positions {places:.3f} ms "
        f"({places / batched:.2f} times), believe {all_of_it:.3f} ms"
    )


def hear(name: str, bank: Bank, remotes: int) -> None:
    """Print what 1,000 messages cost a map that holds so many remotes."""
    around = LocalDynamicMap((bank,), plausibility=Plausibility(), capacity=2 * remotes)
    state = around.init()
    everybody = np.arange(remotes)
    for step in range(2):
        _, state = around.hear(state, messages(bank, everybody, step * DT_S))
    known = messages(bank, np.resize(everybody, MESSAGES), 2 * DT_S, repeated_s=1e-3 * remotes / MESSAGES)
    fresh = messages(bank, np.arange(MESSAGES) + 10 * remotes, 2 * DT_S)
    known_ms = hearing_ms(around, state, known)
    fresh_ms = hearing_ms(around, state, fresh)
    record(f"hear {MESSAGES} messages, {name}", known_ms, "ms", sizes={"remotes": remotes})
    print(f"{name}: {MESSAGES} messages, {remotes} remotes: known {known_ms:.2f} ms, new {fresh_ms:.2f} ms")


def hearing_ms(around: LocalDynamicMap, state: MapState, heard: Heard) -> float:
    """Return the shortest processor time of all rounds [ms]; every message must be accepted."""
    times: list[float] = []
    for _ in range(ROUNDS):
        own = copied(state)
        begin = time.process_time_ns()
        receipts, _ = around.hear(own, heard)
        times.append((time.process_time_ns() - begin) / 1e6)
        if (receipts != Receipt.ACCEPTED).any():
            raise RuntimeError(f"{np.bincount(receipts)} messages by receipt")
    return min(times)


def messages(bank: Bank, vehicle: IntArray, t_s: float, *, repeated_s: float = 0.0) -> Heard:
    """Return an update of each of these vehicles on a road of many lanes, by all sub-models in turn.

    A vehicle that is named again speaks ``repeated_s`` later each time.
    """
    count = vehicle.size
    speed = 20.0 + np.asarray(vehicle % 7, dtype=np.float64)
    turn = np.floor_divide(np.arange(count, dtype=np.float64), max(np.unique(vehicle).size, 1))
    at_s = t_s + repeated_s * turn
    column, lane = (vehicle % 400).astype(np.float64), (vehicle // 400).astype(np.float64)
    position_m = np.stack([37.0 * column + speed * at_s, 37.0 * lane], axis=1)
    unknown = np.full(count, np.nan)
    return Heard(
        np.full(count, int(HeardKind.UPDATE)),
        vehicle,
        np.full(count, round(10 * t_s) % 128),
        t_s=at_s,
        received_s=np.maximum.accumulate(at_s),
        position_m=position_m,
        speed_mps=speed,
        heading_rad=np.full(count, np.pi / 2),
        acceleration_mps2=unknown,
        yaw_rate_radps=unknown,
        profile=np.zeros(count, dtype=np.int64),
        in_use=vehicle % len(bank.members),
        parameters=fitted(bank, speed),
        length_m=unknown,
        width_m=unknown,
        user=np.full(count, -1),
    )


def fitted(bank: Bank, speed: FloatArray) -> FloatArray:
    """Return parameters of all sub-models for steady motion east, (K, P)."""
    most = max(member.window for member in bank.members)
    rows: list[FloatArray] = []
    speeds, which = np.unique(speed, return_inverse=True)
    for one in speeds:
        t = np.arange(-most + 1, 1) * DT_S
        window = np.zeros((1, most, 7))
        window[0, :, 0], window[0, :, 2] = one * t + 0.05 * t**2, one + 0.1 * t
        window[0, :, 4], window[0, :, 5] = 0.1, 0.01
        rows.append(bank.fit(Windows(window, dt_s=DT_S))[0, 1:])
    return np.array(rows)[which]


def least_ms(run: Callable[[], object]) -> float:
    """Return the shortest of all rounds, since other work may run [ms]."""
    run()
    times: list[float] = []
    for _ in range(10 * ROUNDS):
        begin = time.perf_counter_ns()
        run()
        times.append((time.perf_counter_ns() - begin) / 1e6)
    return min(times)


if __name__ == "__main__":
    sys.exit(main())
