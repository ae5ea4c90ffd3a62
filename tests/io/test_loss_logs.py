"""Logs of what was heard, read as losses: those that were made are found, and what tells none is refused."""

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io import text_blocks
from modelcast.io.loss_logs import read_loss_logs

COUNT = 400


def losses(seed=0, count=COUNT):
    """Losses of a link, one by one and in bursts, the ends heard."""
    rng = np.random.default_rng(seed)
    lost = rng.random(count) < 0.2
    for start in rng.integers(10, count - 30, 3):
        lost[start : start + 12] = True
    lost[[0, 1, -2, -1]] = False
    return lost


def rows(made, lost, sender=5, receiver=7, since=0):
    """What a receiver logged of a sender; where TxRandom changes the count jumps, as in Safety Pilot."""
    return [
        made.bsm_row(
            since + at, RxDevice=receiver, TxDevice=sender, MsgCount=(at + 31 * (at >= 300)) % 128,
            TxRandom=-9018 + (at >= 300),
        )
        for at in np.flatnonzero(~lost)
    ]  # fmt: skip


def the_log(path):
    (log,) = read_loss_logs([path])
    return log


@pytest.mark.parametrize("block_bytes", [text_blocks.BLOCK_BYTES, 1500])
@pytest.mark.parametrize("with_header", [True, False])
def test_links_of_a_receiver_are_told_apart(made, monkeypatch, with_header, block_bytes):
    """Rows of two senders and of the receiver itself, in disorder, some twice, whatever the blocks."""
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", block_bytes)
    first, second = losses(1), losses(2)
    first[298:302] = second[298:302] = False
    own = [made.bsm_row(at) for at in range(50)]
    heard = [*rows(made, first), *rows(made, second, sender=6, since=9000), *own]
    heard = [heard[at] for at in np.random.default_rng(3).permutation(len(heard))] + heard[:20]
    content = made.lines(heard, header=made.bsm_header if with_header else None)
    log = the_log(made.write("rx.csv", content))
    found = {link.name: link.lost for link in log.channel.links}
    assert set(found) == {"7 hears 5, file 70", "7 hears 6, file 70"}
    assert np.array_equal(found["7 hears 5, file 70"], first)
    assert np.array_equal(found["7 hears 6, file 70"], second)
    assert [link.unknown for link in log.channel.links] == [0, 0]
    assert (log.heard.own, log.heard.uncounted) == (1, 0)
    assert log.channel.packet_error_ratio == (first.sum() + second.sum()) / (2 * COUNT)


def test_a_count_that_jumps_over_a_gap_ends_a_part(made):
    lost = losses(4)
    lost[295:305] = True
    log = the_log(made.write("rx.csv", made.lines(rows(made, lost))))
    (link,) = log.channel.links
    last = int(np.flatnonzero(~lost[:300])[-1])
    assert np.array_equal(link.lost, lost[: last + 1])
    assert (link.unknown, link.short) == (1, 1)
    assert "1 span" in log.as_text()


def test_rows_without_time_or_count_are_counted(made):
    lost = np.zeros(COUNT, dtype=np.bool_)
    heard = rows(made, lost)
    heard[50] = made.bsm_row(50, TxDevice=5, MsgCount="", TxRandom=-9018)
    heard[60] = made.bsm_row(60, TxDevice=5, GenTime="NULL", TxRandom=-9018)
    heard[70] = made.bsm_row(70, TxDevice=5, MsgCount=70, TxRandom="")
    log = the_log(made.write("rx.csv", made.lines(heard)))
    (link,) = log.channel.links
    assert log.heard.uncounted == 2
    assert np.flatnonzero(link.lost).tolist() == [50, 60]
    assert "2 messages without time or count" in log.as_text()


def test_what_the_log_holds_is_said_in_one_line(made):
    lost = np.zeros(200, dtype=np.bool_)
    lost[50:60] = lost[100:130] = True
    far = np.zeros(20, dtype=np.bool_)
    own = [made.bsm_row(0)]
    heard = [*rows(made, lost), *rows(made, lost, since=900), *rows(made, far, sender=6), *own]
    assert the_log(made.write("rx.csv", made.lines(heard))).as_text() == (
        "rx.csv: 1 link, 400 messages, 20 % lost in bursts of 2 s on average, 3 s at most; not replayed: "
        "1 span (70.1 s) in which counts and times do not agree, 1 part under 100 messages, 1 link without "
        "a longer part, 1 log of own messages"
    )


@pytest.mark.parametrize("count", ["128", "-1", "2.5"])
def test_a_count_that_is_none_is_named_with_its_row(made, count):
    heard = [made.bsm_row(at, RxDevice=9) for at in range(5)]
    heard[3] = made.bsm_row(3, RxDevice=9, MsgCount=count)
    with pytest.raises(DataFormatError, match=rf"row 5: MsgCount is {count}"):
        the_log(made.write("rx.csv", made.lines(heard, header=made.bsm_header)))


def test_what_tells_no_losses_is_told_and_what_to_name_instead(made):
    own = [made.bsm_row(at) for at in range(200)]
    short = [made.bsm_row(at, RxDevice=9) for at in range(50)]
    still = [made.bsm_row(at, RxDevice=9, MsgCount=3) for at in range(200)]
    for name, content, told in (
        ("own.csv", made.lines(own), "own messages alone"),
        ("short.csv", made.lines(short), "100 messages in a row"),
        ("still.csv", made.lines(still), "100 messages in a row"),
        ("empty.csv", b"", "the file is empty"),
        ("head.csv", made.lines([made.bsm_header]), "holds no message"),
        ("uncounted.csv", made.lines(short, header=made.bsm_header.replace("MsgCount", "Count")), "MsgCount"),
        ("rv.csv", b"Device,Trip,Time,RvDevice,LatitudeRv\n1,2,3,4,5\n", "DataRv has no counts"),
        ("rx.csv", b"DeviceID,Trip,Time,RV_ID,RV_Type\n1,2,3,4,5\n", "RV_RX has no counts"),
        ("other.csv", b"t,x,y\n0,1,2\n", "does not tell"),
    ):
        with pytest.raises(DataFormatError, match=told) as raised:
            the_log(made.write(name, content))
        assert name in str(raised.value)
        if told != "MsgCount":
            assert "BsmP1" in str(raised.value)
    with pytest.raises(ConfigError, match="nowhere"):
        read_loss_logs([made.folder / "nowhere.csv"])


def test_an_event_s_host_heard_the_others(made):
    """Messages lost, repeated and out of order; the host's own have gaps too, which are no losses."""
    lost = losses(5, 160)
    order = np.random.default_rng(1).permutation(np.flatnonzero(~lost)).tolist()
    heard = [made.nyc_message(at, "B", msgCnt=(at + 100) % 128) for at in [*order, *order[:9]]]
    own = [made.nyc_message(at, "A", msgCnt=at % 128) for at in range(0, 120, 3)]
    log = the_log(made.write("event.json", made.nyc([*heard, *own], hostVehID="A")))
    (link,) = log.channel.links
    assert link.name == "A hears B"
    assert np.array_equal(link.lost, lost)
    assert log.heard.own == 1


@pytest.mark.parametrize(
    ("header", "changed", "told"),
    [
        ({}, {"msgCnt": 3}, "hostVehID"),
        ({"hostVehID": "A"}, {"msgCnt": 300}, "row 1: msgCnt is 300"),
        ({"hostVehID": "A"}, {"msgCnt": "x"}, "row 1: msgCnt is 'x'"),
        ({"hostVehID": "A"}, {}, "100 messages in a row"),
        ({"hostVehID": "B"}, {"msgCnt": 3}, "own messages alone"),
    ],
)
def test_an_event_that_tells_no_losses_is_refused(made, header, changed, told):
    messages = [made.nyc_message(at, "B", **changed) for at in range(9)]
    with pytest.raises(DataFormatError, match=told):
        the_log(made.write("event.json", made.nyc(messages, **header)))


def test_each_log_is_read_once_and_named_by_its_file(made, tmp_path):
    one = made.write("rx.csv", made.lines(rows(made, losses(1))))
    again = made.write("copy.csv", one.read_bytes())
    (tmp_path / "more").mkdir()
    other = tmp_path / "more" / "rx.csv"
    other.write_bytes(made.lines(rows(made, losses(2))))
    logs = read_loss_logs([one, again, other])
    assert [log.name for log in logs] == ["rx.csv", "rx.csv#2"]
    assert logs[0].sha256 != logs[1].sha256


@pytest.mark.real
def test_of_the_new_york_event_nothing_is_lost(data_folder):
    log = the_log(data_folder / "nyc_cvpd" / "nycdot-fcw-event.json")
    (link,) = log.channel.links
    assert (link.lost.size, link.lost.sum(), link.heard, link.unknown) == (161, 0, 161, 0)
    assert log.heard.own == 1


@pytest.mark.real
@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("bsm_p1_dev.csv", "own messages alone"),
        ("formats/one_day/BsmP1_04_11_13_02_20_14_04.csv", "own messages alone"),
        ("formats/two_month/april_BsmP1.csv", "own messages alone"),
        ("formats/one_day/DataRv_11_04_2013_FINAL.csv", "DataRv has no counts"),
        ("formats/two_month/RV_RX_01_30_04_2013_FINAL.csv", "RV_RX has no counts"),
        ("formats/two_month/RSE_BSM.csv", "does not tell"),
        ("formats/two_month/RSE_BSM_head.csv", "RSE_BSM has times within a minute"),
    ],
)
def test_safety_pilot_files_that_tell_no_losses_say_so(data_folder, name, told):
    with pytest.raises(DataFormatError, match=told):
        the_log(data_folder / "spmd" / name)
