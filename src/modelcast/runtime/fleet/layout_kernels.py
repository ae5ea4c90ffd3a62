"""Names of columns and codes that the compiled loop and its callers share."""

__all__ = [
    "AIRTIME_S",
    "BELIEF_AGE_BIN",
    "BELIEF_COLUMNS",
    "BELIEF_ERROR_BIN",
    "BELIEF_NUMBER",
    "BELIEF_STEP",
    "CAUSES",
    "CERTIFICATES",
    "CONTENT_BYTES",
    "CONTENT_EAST_M",
    "CONTENT_FIT_S",
    "CONTENT_HEAD",
    "CONTENT_MEMBER",
    "CONTENT_NORTH_M",
    "CONTENT_NUMBER",
    "CONTENT_SENT_S",
    "CONTENT_VEHICLE",
    "FAR",
    "FRAME_BYTES",
    "MESSAGES",
    "MESSAGES_KEPT",
    "MODELS",
    "PAYLOAD_BYTES",
    "POWER_DBM",
    "REFUSED",
    "RULE_CAM",
    "RULE_ERROR_DRIVEN",
    "RULE_J2945",
    "RULE_PERIODIC",
    "SENDER_BITS",
    "STALE",
    "SUMS",
    "TAKEN",
    "TRACK_COLUMNS",
    "TRACK_MESSAGE",
    "TRACK_RECEIVED_S",
    "TRACK_VEHICLE",
]

MESSAGES_KEPT = 128
"""Messages of a sender that its ring holds; the message count on the air (DE_MsgCount) runs modulo it too."""

SENDER_BITS = 20
"""Bits of a message's id on the radio that say whose it is; its number stands above them."""

(
    CONTENT_VEHICLE,
    CONTENT_NUMBER,
    CONTENT_FIT_S,
    CONTENT_SENT_S,
    CONTENT_EAST_M,
    CONTENT_NORTH_M,
    CONTENT_MEMBER,
    CONTENT_BYTES,
) = range(8)
"""Columns of a message's content: who sent it and its number; time of its sample, and when it was handed to
the radio; the position stated; the sub-model; payload bytes. Parameters follow."""

CONTENT_HEAD = 8

BELIEF_NUMBER, BELIEF_STEP, BELIEF_ERROR_BIN, BELIEF_AGE_BIN = range(4)
"""Columns of what a message makes its holders believe at one step: its number; the step; bins of the tracking
error (-1 where its sender has left) and of the information age."""

BELIEF_COLUMNS = 4

TRACK_MESSAGE, TRACK_RECEIVED_S, TRACK_VEHICLE = range(3)
"""Columns of a track: id of the message held, when the last one arrived, whose they are."""

TRACK_COLUMNS = 4  # a power of two: a track never straddles two cache lines

RULE_PERIODIC, RULE_ERROR_DRIVEN, RULE_J2945, RULE_CAM = range(4)
"""Codes of the rules."""

CAUSES = 4
"""Causes of a message as `j2945_kernels` numbers them; the others count under time (1)."""

(
    MESSAGES,
    MODELS,
    CERTIFICATES,
    PAYLOAD_BYTES,
    FRAME_BYTES,
    AIRTIME_S,
    POWER_DBM,
    TAKEN,
    FAR,
    REFUSED,
    STALE,
) = range(11)
"""Sums: messages handed to the radio, those with a model, with a certificate; bytes, bytes of frames,
airtime, power; receptions taken in, of remotes out of reach, without a free slot, older than what is held."""

SUMS = 11
