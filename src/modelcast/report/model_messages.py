"""What ``modelcast decode`` shows of modelcast's own messages: model, identification, envelope."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from modelcast.messages.mbc_wire import IdentificationMessage
from modelcast.messages.security.signed import SignedMessage
from modelcast.report.literal import literal

if TYPE_CHECKING:
    from modelcast.messages.update_document import ModelReading

__all__ = ["envelope_table", "identification_table", "model_table", "title_line"]

_UNITS = {"mps2": "m/s²", "radps": "rad/s", "mps": "m/s", "rad": "rad", "m": "m", "s": "s"}


def model_table(reading: "ModelReading") -> RenderableType:
    """The model of an update: profile, sub-model, coefficients with units, predicted displacement.

    Parameters
    ----------
    reading
        The model as read.
    """
    extension = reading.extension
    held = reading.name is not None
    rows = [
        ("profile", f"{extension.profile:06x}, {'held' if held else 'not held'}"),
        ("sub-model", f"{extension.sub_model}{f', {reading.name}' if held else ''}"),
        ("carries", "all sub-models" if extension.carries_all else "the sub-model in use"),
    ]
    if not held:
        count = len(extension.coefficients)
        rows.append(("coefficients", f"{count} bytes: {extension.coefficients.hex()}"))
    rows += [
        (f"{member}: {label}", f"{value:.6g} {unit}".rstrip())
        for member, own in reading.coefficients.items()
        for label, unit, value in (_labelled(name, value) for name, value in own.items())
    ]
    for horizon, (east, north) in zip((1, 2, 3), reading.predicted_m or (), strict=False):
        rows.append((f"displacement after {horizon} s", f"{east:.2f} m east, {north:.2f} m north"))
    lines = [] if held else [Text("unknown profile: constant velocity from Part I is predicted")]
    if reading.problem:
        lines.append(literal(f"nothing is predicted: {reading.problem}"))
    return Group(Text("model"), _table(rows), *lines)


def _labelled(name: str, value: float) -> tuple[str, str, float]:
    """Name without unit, unit, value."""
    quantity, _, suffix = name.rpartition("_")
    if suffix not in _UNITS or not quantity:
        return name.replace("_", " "), "", value
    return quantity.replace("_", " "), _UNITS[suffix], value


def identification_table(message: IdentificationMessage, title: str) -> RenderableType:
    """Fields of an identification with their units.

    Parameters
    ----------
    message
        The identification.
    title
        What stands above.
    """
    rows = [
        ("temporary id", f"{message.temporary_id:08x}"),
        ("sequence", str(message.sequence)),
        ("sub-model", str(message.sub_model)),
        ("age", f"{message.age_s:.2f} s"),
    ]
    return Group(literal(title), _table(rows))


def envelope_table(message: SignedMessage, title: str) -> RenderableType:
    """Fields of a signed message, without its payload.

    Parameters
    ----------
    message
        The envelope.
    title
        What stands above.
    """
    signer = message.signer
    rows = [
        ("application", f"{message.psid:#x}"),
        ("generation time", f"{message.generation_us} µs"),
        ("certificate digest", message.digest.hex()),
    ]
    if not isinstance(signer, bytes):
        rows += [
            ("issuer", signer.issuer.hex() or "itself"),
            ("name", "none" if signer.name is None else signer.name),
            ("may", "sign for " + ", ".join(map(hex, signer.psids)) if signer.psids else "issue"),
            ("start", f"{signer.start_s} s"),
            ("duration", f"{signer.duration_s} s"),
            ("public key", signer.public_key.hex()),
            ("certificate signature", signer.signature.hex()),
        ]
    rows += [("signature", message.signature.hex()), ("payload", f"{len(message.payload)} bytes")]
    return Group(literal(title), _table(rows), Text("the signature is not verified"))


def title_line(title: str) -> RenderableType:
    """A line above other tables.

    Parameters
    ----------
    title
        Any text.
    """
    return literal(title)


def _table(rows: Iterable[tuple[str, str]]) -> Table:
    table = Table()
    table.add_column("field", no_wrap=True)
    table.add_column("value", overflow="fold")
    for name, value in rows:
        table.add_row(name, value)
    return table
