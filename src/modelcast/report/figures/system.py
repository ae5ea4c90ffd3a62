"""The two diagrams of the system: who does what from a measurement to a belief, and Algorithm 1.

Every name in them is asked of the code's own parts, so a part that moves is drawn where it is.
"""

from matplotlib.figure import Figure

from modelcast.channel.radio import AbstractRadio
from modelcast.report.figures.diagram import Box, diagram_axes, draw_arrow, draw_box
from modelcast.report.style import IDENTIFICATION_COLOUR, PAGE_IN, POLICY_COLOURS, model_colours, style
from modelcast.runtime.transport.base import AbstractTransport
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import PAPER_BANK
from modelcast.station.policy.base import MessageKind
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap
from modelcast.station.sender.octets import StationOctets
from modelcast.station.station import Station
from modelcast.study.paper.choices import CHOICES

__all__ = ["ALGORITHM_BOXES", "SYSTEM_BOXES", "plot_algorithm", "plot_system"]

_REMOTE = "#eaf3fa"
_HOST = "#fdf1e3"
_WIDE = 44.0
_RADIO_STEP: object = getattr(AbstractRadio, "step")  # noqa: B009 - its state may be of any type


def _members() -> tuple[Box, ...]:
    """One box a sub-model of the paper's bank."""
    members = PAPER_BANK.members
    colours = model_colours([member.name for member in members])
    width = _WIDE / len(members) - 1.0
    return tuple(
        Box(
            member.name,
            (f"window {member.window}",),
            (type(member),),
            x=1.5 + width / 2 + at * (width + 2.0),
            y=47.5,
            width=width,
            height=14.0,
            colour=colours[member.name],
            fill=_REMOTE,
        )
        for at, member in enumerate(members)
    )


SYSTEM_BOXES = {
    "sensors": Box(
        "GPS and CAN",
        ("position, speed, heading, acceleration, yaw rate",),
        x=23.5,
        y=82.0,
        width=_WIDE,
        height=8.0,
    ),
    "sense": Box(
        "Sense",
        ("local east and north; velocities, rates, noise",),
        (Station.sense,),
        x=23.5,
        y=66.5,
        width=_WIDE,
        height=14.0,
        fill=_REMOTE,
    ),
    **{f"member {at}": box for at, box in enumerate(_members())},
    "decide": Box(
        "Decide: Algorithm 1",
        ("errors of the copies that receivers hold",),
        (ErrorDriven.decide,),
        x=23.5,
        y=28.5,
        width=_WIDE,
        height=14.0,
        colour=POLICY_COLOURS["mbc"],
        fill=_REMOTE,
    ),
    "encode": Box(
        "Speak",
        (f"{MessageKind.UPDATE.label} or {MessageKind.IDENTIFICATION.label}, in octets",),
        (StationOctets.encode,),
        x=23.5,
        y=9.5,
        width=_WIDE,
        height=14.0,
        fill=_REMOTE,
    ),
    "radio": Box(
        "Any radio",
        ("DSRC, C-V2X mode 4, sockets; loses some",),
        (_RADIO_STEP, AbstractTransport.send),
        x=73.0,
        y=12.0,
        width=40.0,
        height=19.0,
    ),
    "hear": Box(
        "Hear",
        ("octets to content; nothing in them is trusted",),
        (Ears.hear,),
        x=121.5,
        y=9.5,
        width=_WIDE,
        height=14.0,
        fill=_HOST,
    ),
    "map": Box(
        "Local dynamic map",
        ("a row a remote: sub-model in use, its parameters",),
        (LocalDynamicMap.hear,),
        x=121.5,
        y=32.0,
        width=_WIDE,
        height=14.0,
        fill=_HOST,
    ),
    "believe": Box(
        "Believe",
        ("where every remote is, at any time",),
        (LocalDynamicMap.believe,),
        x=121.5,
        y=54.5,
        width=_WIDE,
        height=14.0,
        fill=_HOST,
    ),
    "applications": Box(
        "Safety applications", ("functions of the map",), x=121.5, y=77.0, width=_WIDE, height=9.0
    ),
}
"""The boxes of the diagram of the system, by what they are."""


def plot_system() -> Figure:
    """Return the remote vehicle that sends, any radio, and the host vehicle that keeps the map."""
    with style():
        figure = Figure(figsize=(PAGE_IN, 4.6))
        axes = diagram_axes(figure, 145.0, 93.0)
        boxes = SYSTEM_BOXES
        for box in boxes.values():
            draw_box(axes, box)
        axes.text(23.5, 88.5, "Remote vehicle", ha="center", fontsize=8.0, fontweight="bold")
        axes.text(121.5, 88.5, "Host vehicle", ha="center", fontsize=8.0, fontweight="bold")
        draw_arrow(axes, [boxes["sensors"].bottom, boxes["sense"].top])
        for at in range(len(PAPER_BANK.members)):
            member = boxes[f"member {at}"]
            draw_arrow(axes, [(member.x, boxes["sense"].bottom[1]), member.top])
            draw_arrow(axes, [member.bottom, (member.x, boxes["decide"].top[1])])
        draw_arrow(axes, [boxes["decide"].bottom, boxes["encode"].top])
        draw_arrow(axes, [boxes["encode"].right, (boxes["radio"].left[0], boxes["encode"].y)])
        draw_arrow(axes, [(boxes["radio"].right[0], boxes["hear"].y), boxes["hear"].left])
        for below, above in (("hear", "map"), ("map", "believe"), ("believe", "applications")):
            draw_arrow(axes, [boxes[below].top, boxes[above].bottom])
        copy = boxes["encode"].right[0] + 5.0
        draw_arrow(
            axes,
            [(copy, boxes["encode"].y), (copy, boxes["decide"].y), boxes["decide"].right],
        )
        axes.text(copy + 0.8, boxes["decide"].y - 2.5, "the decoded copy", fontsize=5.8)
        return figure


def _rule(field: str) -> str:
    """The options that the paper leaves open, on one line."""
    (choice,) = (one for one in CHOICES if one.field == field)
    return f"{choice.title}: {', '.join(option.label for option in choice.options)}"


ALGORITHM_BOXES = {
    "errors": Box(
        "A new position",
        ("error of every sub-model fitted at T0",),
        (TripRuntime.tracking_error_m,),
        x=25.0,
        y=38.5,
        width=44.0,
        height=14.0,
    ),
    "any": Box(
        "Smallest error", ("under the threshold?",), x=72.0, y=38.5, width=36.0, height=18.0, is_question=True
    ),
    "in use": Box(
        "Sub-model in use",
        ("under the threshold?",),
        x=72.0,
        y=12.0,
        width=36.0,
        height=18.0,
        is_question=True,
    ),
    "update": Box(
        MessageKind.UPDATE.label.capitalize(),
        ("T0 is now, all sub-models are fitted anew", _rule("start")),
        x=121.0,
        y=38.5,
        width=46.0,
        height=13.0,
        colour=POLICY_COLOURS["mbc"],
    ),
    "identification": Box(
        MessageKind.IDENTIFICATION.label.capitalize(),
        ("names the one with the smallest error", _rule("identify")),
        x=121.0,
        y=12.0,
        width=46.0,
        height=13.0,
        colour=IDENTIFICATION_COLOUR,
    ),
    "nothing": Box(
        MessageKind.NOTHING.label.capitalize(),
        ("the host goes on predicting",),
        x=25.0,
        y=12.0,
        width=44.0,
        height=9.0,
    ),
}
"""The boxes of the diagram of Algorithm 1, by what they are."""


def plot_algorithm() -> Figure:
    """Return Algorithm 1 as a flow chart, with the rules that the paper leaves open where they act."""
    with style():
        figure = Figure(figsize=(PAGE_IN, 2.5))
        axes = diagram_axes(figure, 145.0, 50.5)
        boxes = ALGORITHM_BOXES
        for box in boxes.values():
            draw_box(axes, box)
        draw_arrow(axes, [boxes["errors"].right, boxes["any"].left])
        draw_arrow(axes, [boxes["any"].right, boxes["update"].left], "no")
        draw_arrow(axes, [boxes["any"].bottom, boxes["in use"].top], "yes")
        draw_arrow(axes, [boxes["in use"].right, boxes["identification"].left], "no")
        draw_arrow(axes, [boxes["in use"].left, boxes["nothing"].right], "yes")
        draw_arrow(axes, [boxes["nothing"].top, boxes["errors"].bottom], "next sample")
        return figure
