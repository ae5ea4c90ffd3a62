"""Claims about tables in a terminal: places take lines of their own, and cost no column its numbers."""

import pytest
from rich.console import Console, Group

from modelcast.cli.terminal import show
from modelcast.core.cells import Cells
from modelcast.report.console_table import ConsoleTable, console_table, placed_table
from modelcast.report.literal import Prose

LONG = "dsrc:path_loss=two-ray,antenna_m=1.5,shadowing=none, 25/km"
HEADS = ["policy", "messages [1/s]", "bytes/s", "CBR [%]", "PTE p90 [m]", "PTE p99 [m]", "late"]


def shown(places: list[str], names: list[str]) -> str:
    rows = [[name, *(f"{n}.{at}25" for n in range(1, 7))] for at, name in enumerate(names)]
    console = Console(width=80, color_system=None)
    with console.capture() as captured:
        console.print(
            placed_table(Cells(HEADS, rows, 1), places, "A title", padding=(0, 0, 0, 0), min_width=8)
        )
    return captured.get()


@pytest.mark.parametrize("place", ["dsrc, 25/km", LONG, f"{LONG},noise_figure_db=8,antenna_gain_db=3"])
def test_a_place_of_any_length_leaves_every_number_in_80_columns(place: str) -> None:
    text = shown([place, place, "ideal"], ["bsm-10hz", "j2945", "cam"])
    lines = text.splitlines()
    assert max(map(len, lines)) <= 80
    for at in range(3):
        assert all(f"{n}.{at}25" in text for n in range(1, 7))
    told, place = "".join(text.split()), place.replace(" ", "")
    assert told.count(place) == 1
    assert told.index(place) < told.index("bsm-10hz") < told.index("ideal") < told.index("cam")


def test_a_place_has_no_say_in_the_widths_of_columns() -> None:
    rest = [shown([place], ["cam"]).splitlines() for place in ("ideal", LONG)]
    assert [line for line in rest[0] if "ideal" not in line] == [line for line in rest[1] if LONG not in line]


def test_a_name_beyond_24_letters_is_folded_and_the_numbers_stay() -> None:
    name = "j3161-mbc-relaxed:power_control=yes,grant=one-shot"
    text = shown(["dsrc"], [name])
    assert max(map(len, text.splitlines())) <= 80
    assert all(f"{n}.025" in text for n in range(1, 7))
    assert name in "".join(line[1:25].strip() for line in text.splitlines())


def test_a_place_is_no_markup() -> None:
    assert "[red]x\\x07" in shown(["[red]x\x07"], ["cam"])


def printed(table: ConsoleTable, width: int) -> list[str]:
    console = Console(width=width, color_system=None)
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines()]


NUMBERS = tuple(f"{n}{n}{n}.{n}25 [{n}.1, {n}.9]" for n in range(1, 8))


@pytest.mark.parametrize("width", [40, 60, 80, 200, 10_000])
@pytest.mark.parametrize("placed", [True, False])
def test_no_number_is_cut_or_wrapped_at_any_width(width: int, placed: bool) -> None:
    """Columns that have no room stand below, behind the same names."""
    names = ["bsm-10hz", "a sender of many words"]
    cells = Cells([*HEADS, "one more"], [[name, *NUMBERS] for name in names], 1)
    table = placed_table(cells, ["dsrc"] * 2, "A title") if placed else console_table(cells, "A title")
    lines = printed(table, width)
    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    assert all(text.count(number) == len(names) for number in NUMBERS)
    assert "…" not in text
    rows = [line for line in lines if "bsm-10hz" in line]
    assert len(rows) == 1 if width >= 200 else len(rows) > 1
    assert text.count("A title") == 1


def test_in_a_pipe_a_row_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    name = "a name of many words, so that no terminal has room for it in one line of its own " * 3
    show(console_table(Cells([*HEADS, "one more"], [[name, *NUMBERS]], 1)))
    (row,) = [line for line in capsys.readouterr().out.splitlines() if name.strip() in line]
    assert all(number in row for number in NUMBERS)


@pytest.mark.parametrize("columns", [None, "80"])
def test_in_a_pipe_no_line_is_padded_and_prose_has_lines_of_100_columns(
    columns: str | None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    if columns is not None:
        monkeypatch.setenv("COLUMNS", columns)
    cells = Cells(HEADS, [["cam", *(f"{n}.125" for n in range(1, 7))]] * 2, 1)
    prose = "A sentence that goes on, and on. " * 20
    show(Group(Prose(prose), placed_table(cells, ["dsrc", LONG], "A title"), console_table(cells, "Another")))
    lines = capsys.readouterr().out.split("\n")
    assert [line for line in lines if line.endswith(" ")] == []
    assert max(map(len, lines)) <= int(columns or "100")
    assert " ".join(lines).startswith(prose.strip())


def test_rows_of_a_place_are_as_wide_as_the_table_and_not_as_the_room() -> None:
    cells = Cells(HEADS, [["cam", *NUMBERS[:6]]], 1)
    console = Console(width=10_000, color_system=None)
    with console.capture() as captured:
        console.print(placed_table(cells, ["dsrc"], "A title"))
    assert max(map(len, captured.get().splitlines())) < 250
