"""What a sender knows beside its own motion, as columns of its samples: the vehicle ahead, the road ahead.

They stand behind the measured columns and before the state of streaming sub-models. Each is zero where
nothing is known; `LEADER_KNOWN` and `ROAD_KNOWN` tell that from a zero that is known. Where they come from is
`modelcast.station.context`.
"""

__all__ = [
    "CONTEXT_COLUMNS",
    "CONTEXT_NAMES",
    "LEADER_ACCELERATION",
    "LEADER_ACCELERATION_BEFORE",
    "LEADER_GAP",
    "LEADER_KNOWN",
    "LEADER_RELATIVE_SPEED",
    "ROAD_HEADING",
    "ROAD_KNOWN",
    "ROAD_TURN",
    "ROAD_TURN_HORIZONS",
]

ROAD_TURN_HORIZONS = 6
"""The road's turn is told 1, 2, ... so many seconds ahead at the present speed."""

LEADER_GAP, LEADER_RELATIVE_SPEED, LEADER_ACCELERATION, LEADER_ACCELERATION_BEFORE, LEADER_KNOWN = range(5)
"""Distance to the vehicle ahead, antenna to antenna [m]; its speed minus the own [m/s]; its acceleration
along its course as believed now, and as believed half a second ago [m/s²]; 1 where there is one, else 0."""

ROAD_TURN = 5
"""First of `ROAD_TURN_HORIZONS` columns: heading of the remembered road there minus that at the matched
place, clockwise [rad]."""

ROAD_HEADING, ROAD_KNOWN = ROAD_TURN + ROAD_TURN_HORIZONS, ROAD_TURN + ROAD_TURN_HORIZONS + 1
"""Heading of the remembered road at the matched place minus the own course, wrapped [rad]; 1 where the road
is remembered, else 0."""

CONTEXT_COLUMNS = ROAD_KNOWN + 1
"""How many columns of context there are."""

CONTEXT_NAMES = (
    "leader_gap_m",
    "leader_relative_speed_mps",
    "leader_acceleration_mps2",
    "leader_acceleration_before_mps2",
    "leader_known",
    *(f"road_turn_{second}s_rad" for second in range(1, ROAD_TURN_HORIZONS + 1)),
    "road_heading_rad",
    "road_known",
)
"""Their names, in order."""
