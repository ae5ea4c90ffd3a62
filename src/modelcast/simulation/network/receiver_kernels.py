"""Compiled receivers of the closed loop: every host takes in what it hears and tracks every remote."""

from math import hypot
from typing import Any

import numba

from modelcast.channel.grid_kernels import build_grid, cell_span
from modelcast.models.trusted_kernels import predict_trusted
from modelcast.policy.neighbours_kernels import hear
from modelcast.simulation.network.bins_kernels import bin_of
from modelcast.simulation.network.layout_kernels import (
    CONTENT_EAST_M,
    CONTENT_FIT_S,
    CONTENT_HEAD,
    CONTENT_MEMBER,
    CONTENT_NORTH_M,
    CONTENT_NUMBER,
    CONTENT_VEHICLE,
    FAR,
    MESSAGES_KEPT,
    REFUSED,
    STALE,
    TAKEN,
    TRACK_MESSAGE,
    TRACK_RECEIVED_S,
    TRACK_VEHICLE,
)

__all__ = ["clear_hosts", "count_pairs", "hear_messages", "most_in_reach", "sample_tracks"]


@numba.njit(cache=True, nogil=True)
def clear_hosts(started: Any, tables: Any, tracks: Any) -> None:
    """Let new vehicles hold nothing: ``started`` (V,) says whose slot has one."""
    hosts, slots, index, _ = tables
    for host in range(started.size):
        if started[host]:
            for slot in range(hosts[host].used):
                slots[host, slot].remote = -1
                tracks[host, slot, TRACK_MESSAGE] = -1.0
            hosts[host].used = 0
            hosts[host].free = 0
            for at in range(index.shape[1]):
                index[host, at] = -1


@numba.njit(cache=True, nogil=True)
def hear_messages(
    message_id: Any,
    receiver: Any,
    received_s: Any,
    vehicle: Any,
    seen_m: Any,
    truth_m: Any,
    reach_m: float,
    sub_interval_s: float,
    distance_bin_m: float,
    tables: Any,
    contents: Any,
    tracks: Any,
    tally: Any,
) -> None:
    """Take in receptions, (R,) each, in the order of time.

    A host passes over remotes that state a place farther than ``reach_m``, and messages no newer than what
    it holds. Inter-packet gaps are counted by the true distance.
    """
    hosts, slots, index, free = tables
    vehicles, distances = vehicle.size, tally.gap.shape[0]
    for k in range(message_id.size):
        host = receiver[k]
        sender, number = message_id[k] % vehicles, message_id[k] // vehicles
        content = contents.rows[sender, number % MESSAGES_KEPT]
        if vehicle[host] < 0 or content[CONTENT_NUMBER] != number:
            tally.sums[STALE] += 1.0
            continue
        east, north = content[CONTENT_EAST_M] - seen_m[host, 0], content[CONTENT_NORTH_M] - seen_m[host, 1]
        if east * east + north * north > reach_m * reach_m:
            tally.sums[FAR] += 1.0
            continue
        remote = int(content[CONTENT_VEHICLE])
        slot = hear(
            hosts, slots, index, free, host, remote, number % MESSAGES_KEPT, received_s[k],
            content[CONTENT_EAST_M], content[CONTENT_NORTH_M], sub_interval_s,
        )  # fmt: skip
        if slot < 0:
            tally.sums[REFUSED] += 1.0
            continue
        tally.sums[TAKEN] += 1.0
        track = tracks[host, slot]
        if track[TRACK_MESSAGE] >= 0.0 and track[TRACK_VEHICLE] == remote:
            if number <= int(track[TRACK_MESSAGE]) // vehicles:
                tally.sums[STALE] += 1.0
                continue
            east, north = truth_m[sender, 0] - truth_m[host, 0], truth_m[sender, 1] - truth_m[host, 1]
            distance = int(hypot(east, north) / distance_bin_m)
            if distance < distances and vehicle[sender] == remote:
                tally.gap[distance, bin_of(received_s[k] - track[TRACK_RECEIVED_S])] += 1
        track[TRACK_MESSAGE], track[TRACK_RECEIVED_S], track[TRACK_VEHICLE] = message_id[k], received_s[k], remote


@numba.njit(cache=True, nogil=True)
def _predicted(models: Any, content: Any, t_s: float, out: Any) -> None:
    """Where a message puts its sender at a time, into ``out`` (2,)."""
    _, predicts, constants, _, counts, trust, _ = models
    member = int(content[CONTENT_MEMBER])
    predict_trusted(
        predicts[member],
        content[CONTENT_HEAD : CONTENT_HEAD + counts[member]],
        t_s - content[CONTENT_FIT_S],
        constants[member],
        trust[member, 0],
        trust[member, 1],
        out,
    )
    out[0] += content[CONTENT_EAST_M]
    out[1] += content[CONTENT_NORTH_M]


@numba.njit(cache=True, nogil=True)
def sample_tracks(
    models: Any,
    t_s: float,
    step: int,
    expiry_s: float,
    distance_bin_m: float,
    middle: Any,
    vehicle: Any,
    truth_m: Any,
    tables: Any,
    contents: Any,
    tracks: Any,
    tally: Any,
    scratch: Any,
) -> None:
    """Count the tracking error and information age of every live track now, by true distance.

    What a message predicts is worked out once, whoever holds it. ``middle`` are the first and the end bin of
    distance that also count in ``tally.recent``. Remotes that have left are passed over.
    """
    hosts, slots, _, _ = tables
    vehicles, distances = vehicle.size, tally.error.shape[0]
    most_m = distance_bin_m * distances
    for host in range(vehicles):
        if vehicle[host] < 0:
            continue
        east_m, north_m = truth_m[host, 0], truth_m[host, 1]
        for slot in range(hosts[host].used):
            track = tracks[host, slot]
            if slots[host, slot].remote < 0 or t_s - track[TRACK_RECEIVED_S] > expiry_s:
                continue
            message = int(track[TRACK_MESSAGE])
            sender = message % vehicles
            east, north = truth_m[sender, 0] - east_m, truth_m[sender, 1] - north_m
            square = east * east + north * north
            if square >= most_m * most_m:
                continue
            ring = (message // vehicles) % MESSAGES_KEPT
            if contents.rows[sender, ring, CONTENT_NUMBER] != message // vehicles:
                continue
            if contents.stamp[sender, ring] != step:
                content = contents.rows[sender, ring]
                contents.stamp[sender, ring] = step
                if content[CONTENT_VEHICLE] != vehicle[sender]:
                    contents.error_bin[sender, ring] = -1
                else:
                    _predicted(models, content, t_s, scratch)
                    error_m = hypot(scratch[0] - truth_m[sender, 0], scratch[1] - truth_m[sender, 1])
                    contents.error_bin[sender, ring] = bin_of(error_m)
                    contents.age_bin[sender, ring] = bin_of(t_s - content[CONTENT_FIT_S])
            error = contents.error_bin[sender, ring]
            if error < 0:
                continue
            distance = int(square**0.5 / distance_bin_m)
            tally.held[distance] += 1
            tally.error[distance, error] += 1
            tally.age[distance, contents.age_bin[sender, ring]] += 1
            if middle[0] <= distance < middle[1]:
                tally.recent[error] += 1


@numba.njit(cache=True, nogil=True)
def count_pairs(position_m: Any, distance_bin_m: float, pairs: Any) -> None:
    """Count all pairs of host and remote by distance, ``pairs`` (distances,); NaN is nobody."""
    most_m = distance_bin_m * pairs.size
    grid = build_grid(position_m, most_m)
    for v in range(position_m.shape[0]):
        east, north = position_m[v, 0], position_m[v, 1]
        if not east == east:  # noqa: PLR0124 - NaN
            continue
        first, last = cell_span(east, grid.corner_east_m, grid.cell_m, grid.columns, most_m)
        low, high = cell_span(north, grid.corner_north_m, grid.cell_m, grid.rows, most_m)
        for row in range(low, high + 1):
            for k in range(grid.start[row * grid.columns + first], grid.start[row * grid.columns + last + 1]):
                a, b = grid.place[k, 0] - east, grid.place[k, 1] - north
                square = a * a + b * b
                if square < most_m * most_m and grid.order[k] != v:
                    pairs[int(square**0.5 / distance_bin_m)] += 1


@numba.njit(cache=True, nogil=True)
def most_in_reach(position_m: Any, reach_m: float) -> int:
    """Most vehicles within reach of one, itself among them."""
    grid = build_grid(position_m, reach_m)
    most = 0
    for v in range(position_m.shape[0]):
        east, north = position_m[v, 0], position_m[v, 1]
        if not east == east:  # noqa: PLR0124 - NaN
            continue
        first, last = cell_span(east, grid.corner_east_m, grid.cell_m, grid.columns, reach_m)
        low, high = cell_span(north, grid.corner_north_m, grid.cell_m, grid.rows, reach_m)
        near = 0
        for row in range(low, high + 1):
            for k in range(grid.start[row * grid.columns + first], grid.start[row * grid.columns + last + 1]):
                a, b = grid.place[k, 0] - east, grid.place[k, 1] - north
                if a * a + b * b <= reach_m * reach_m:
                    near += 1
        most = max(most, near)
    return most
