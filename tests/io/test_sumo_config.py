"""Claims about SUMO's configurations: what they name, what of their traffic is taken, and what is refused."""

import importlib.util
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.core.kinds import SIZES_M, Kind
from modelcast.io.sumo import run_sumo, survey_sumo
from modelcast.io.sumo_config import SumoConfig, read_sumo_config
from modelcast.io.sumo_roads import junction_input, sumo_home
from modelcast.world.scenario.base import STEP_S
from modelcast.world.scenario.motion import checked

INSTALLED = importlib.util.find_spec("libsumo") is not None and importlib.util.find_spec("sumo") is not None
needs_sumo = pytest.mark.skipif(not INSTALLED, reason="needs SUMO: pip install eclipse-sumo libsumo")

NOT_WRITTEN = frozenset(
    {
        *("configuration-file", "net-file", "route-files", "additional-files", "weight-files", "load-state"),
        *("fcd-output.filter-edges.input-file", "device.ssm.filter-edges.input-file", "phemlight-path"),
        *("astar.all-distances", "astar.landmark-distances", "device.fcd-replay.files"),
        *("gui-settings-file", "edgedata-files", "alternative-net-file", "selection-file"),
        *("save-state.prefix", "save-state.files", "gui-testing.setting-output"),
    }
)
"""Files that SUMO reads; saved states, which its prefix takes away; what its window alone knows."""

USERS = """<routes>
<vType id="lorry" vClass="truck" length="12" width="2.5"/>
<vType id="two" vClass="bicycle" length="1.7" width="0.65"/>
<vType id="express" vClass="rail" length="100"/>
<route id="across" edges="inE outW"/>
<vehicle id="t0" type="lorry" route="across" depart="0" departPos="20"/>
<vehicle id="b" type="two" route="across" depart="0" departPos="60"/>
<vehicle id="r" type="express" depart="0"><route edges="inN outS"/></vehicle>
<person id="b" depart="0" departPos="150"><walk edges="inS outN"/></person>
<vehicle id="t1" type="lorry" route="across" depart="triggered"/>
<person id="guest" depart="2"><ride from="inE" to="outW" lines="t1"/></person>
</routes>
"""
"""Two lorries, a bicycle, a train; one who walks and has the bicycle's name, and one who rides along."""


def configured(folder: Path, *, options: str = "", end: str = "60", users: str = USERS) -> SumoConfig:
    """A configuration of the junction with users of its own."""
    network = junction_input(folder).network
    (folder / "users.rou.xml").write_text(users, encoding="utf-8")
    path = folder / "town.sumocfg"
    path.write_text(
        f'<configuration><input><net-file value="{network.name}"/>'
        '<route-files value="users.rou.xml"/></input>'
        f'<time><begin value="0"/><end value="{end}"/></time>{options}</configuration>',
        encoding="utf-8",
    )
    return read_sumo_config(path)


def test_a_configuration_names_its_files_beside_itself_and_its_outputs(tmp_path: Path) -> None:
    path = tmp_path / "a.sumocfg"
    path.write_text(
        '<sumoConfiguration><input><net-file value="sub/n.net.xml"/><route-files value="a.xml, b.xml c.xml"/>'
        '<additional-files v="d.xml"/></input><output><fcd-output value="f.xml"/></output>'
        '<report><log value="l.txt"/></report><time><end value="3"/></time></sumoConfiguration>',
        encoding="utf-8",
    )
    found = read_sumo_config(path)
    names = [str(one.relative_to(tmp_path)) for one in found.inputs]
    assert names == [str(Path("sub/n.net.xml")), "a.xml", "b.xml", "c.xml", "d.xml"]
    assert found.outputs == ("fcd-output", "log")


@pytest.mark.parametrize(
    "name", ["w", "weight-files", "load-state", "device.fcd-replay.files", "astar.all-distances", "net", "r"]
)
def test_what_changes_the_traffic_is_an_input(name: str, tmp_path: Path) -> None:
    """Runs are taken up again only with the same inputs."""
    path = tmp_path / "a.sumocfg"
    path.write_text(
        f'<configuration><n value="n.xml"/><{name} value="i.xml"/></configuration>', encoding="utf-8"
    )
    assert read_sumo_config(path).inputs == (tmp_path / "n.xml", tmp_path / "i.xml")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<configuration><input>", "row 1: is not well-formed"),
        ("<fcd-export/>", "the root is 'fcd-export'"),
        ("<configuration><time><end value='3'/></time></configuration>", "names a network"),
    ],
)
def test_what_is_no_configuration_is_told(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "a.sumocfg"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((ConfigError, DataFormatError), match=told):
        read_sumo_config(path)


@needs_sumo
def test_every_road_user_is_what_sumo_says_and_the_others_are_counted(tmp_path: Path) -> None:
    source = configured(tmp_path)
    found = survey_sumo(source, duration_s=8.0, people=True)
    assert (found.vehicles, found.most, found.pedestrians, found.cyclists) == (4, 4, 1, 1)
    assert set(found.reading.skipped) == {"not on roads: rail", "person in a vehicle"}
    assert found.taken + sum(found.reading.skipped.values()) == found.reading.rows
    frames = list(run_sumo(source, slots=found.most, duration_s=8.0, people=True))
    assert [frame.t_s for frame in frames] == pytest.approx(np.arange(80) * STEP_S)
    last = frames[-1]
    assert last.kind is not None
    assert last.width_m is not None
    order = np.argsort(last.length_m)
    sizes = np.column_stack((last.length_m, last.width_m))[order].tolist()
    assert sizes == [list(SIZES_M[Kind.PEDESTRIAN]), [1.7, 0.65], [12.0, 2.5], [12.0, 2.5]]
    assert last.kind[order].tolist() == [Kind.PEDESTRIAN, Kind.CYCLIST, Kind.VEHICLE, Kind.VEHICLE]
    alone = survey_sumo(source, duration_s=8.0)
    assert (alone.vehicles, alone.pedestrians, alone.reading.rows) == (3, 0, found.reading.rows)
    assert set(alone.reading.skipped) == {"not on roads: rail", "person"}


@needs_sumo
@pytest.mark.parametrize("step_s", [0.05, 0.1, 0.25, 1.0])
def test_any_step_of_sumo_gives_frames_that_move_as_they_say(step_s: float, tmp_path: Path) -> None:
    source = configured(tmp_path, options=f'<processing><step-length value="{step_s}"/></processing>')
    found = survey_sumo(source, duration_s=12.0, people=True)
    assert found.step_s == pytest.approx(step_s)
    frames = list(checked(run_sumo(source, slots=found.most, duration_s=12.0, people=True)))
    assert len(frames) == 120


@needs_sumo
def test_frames_end_where_the_configuration_does(tmp_path: Path) -> None:
    source = configured(tmp_path, end="7")
    frames = list(run_sumo(source, slots=9, duration_s=30.0))
    assert frames[-1].t_s == pytest.approx(6.0)  # SUMO's steps end at 1 to 7 s
    later = list(run_sumo(source, slots=9, duration_s=30.0, warm_up_s=4.0))
    assert later[-1].t_s == pytest.approx(2.0)
    with pytest.raises(ConfigError, match="nobody is on the roads"):
        survey_sumo(source, duration_s=5.0, warm_up_s=20.0)


WRITTEN = """<additional>
<edgeData id="e" file="sub/edges.xml"/>
<inductionLoop id="d" lane="inE_0" pos="10" period="2" file="loops.xml"/>
</additional>
"""

OUTPUTS = (
    *("tripinfo", "summary", "vehroutes", "ndump", "fcd-output", "full-output", "l", "error-log"),
    *("edgedata-output", "device.rerouting.output"),
)
"""Names of outputs, old and short ones too."""


@needs_sumo
def test_nothing_is_written_beside_the_files_of_a_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine, elsewhere = tmp_path / "mine", tmp_path / "elsewhere"
    for folder in (mine / "sub", elsewhere):
        folder.mkdir(parents=True)
    monkeypatch.chdir(elsewhere)
    own = '<vType id="lorry" vClass="truck"><param key="device.ssm.file" value="ssm.xml"/></vType>'
    users = USERS.replace('<vType id="lorry" vClass="truck" length="12" width="2.5"/>', own)
    named = "".join(f'<{name} value="{name}.xml"/>' for name in OUTPUTS)
    source = configured(
        mine,
        users=users,
        options=f'<o>{named}<save-state.period value="2"/><output-prefix value="mine-"/>'
        '<device.ssm.probability value="1"/><device.rerouting.probability value="1"/>'
        '<additional-files value="more.add.xml"/></o>',
    )
    assert set(source.outputs) == set(OUTPUTS)
    (mine / "more.add.xml").write_text(WRITTEN, encoding="utf-8")
    for name in ("sub/edges.xml", "loops.xml", "tripinfo.xml", "mine-tripinfo.xml"):
        (mine / name).write_text("of the user", encoding="utf-8")

    def contents() -> dict[Path, bytes]:
        return {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}

    before = contents()
    found = survey_sumo(source, duration_s=8.0)
    assert len(list(run_sumo(source, slots=found.most, duration_s=8.0))) == 80
    assert contents() == before
    source.path.write_text(source.path.read_text("utf-8").replace("users.rou", "none.rou"), encoding="utf-8")
    before = contents()
    with pytest.raises(ConfigError, match=r"none\.rou"):
        survey_sumo(source, duration_s=8.0)
    assert contents() == before


@pytest.mark.parametrize("name", ["save-configuration", "save-config", "C", "save-template", "save-schema"])
def test_what_ends_sumo_at_once_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "a.sumocfg"
    path.write_text(
        f'<configuration><n value="n.xml"/><{name} value="o.xml"/></configuration>', encoding="utf-8"
    )
    with pytest.raises(ConfigError, match=rf"a\.sumocfg: {name} \(o\.xml\) makes SUMO write its settings"):
        read_sumo_config(path)


@needs_sumo
def test_every_option_of_sumo_that_names_a_file_is_read_or_written(tmp_path: Path) -> None:
    """SUMO's own list of options, with their other names."""
    listed = tmp_path / "options.xml"
    words = [str(sumo_home() / "bin" / "sumo"), "--save-template", str(listed), "--save-template.commented"]
    subprocess.run(words, check=True, capture_output=True)  # noqa: S603 - SUMO's own program
    files = re.findall(
        r'<(\S+) value="[^"]*" (?:synonymes="([^"]*)" )?(?:deprecated="[^"]*" )?type="FILE"',
        listed.read_text(encoding="utf-8"),
    )
    assert len(files) > 50
    names = {name for own, others in files if own not in NOT_WRITTEN for name in (own, *others.split())}
    path = tmp_path / "a.sumocfg"
    for name in sorted(names):
        path.write_text(
            f'<configuration><n value="n.xml"/><{name} value="o.xml"/></configuration>', encoding="utf-8"
        )
        try:
            assert read_sumo_config(path).outputs == (name,)
        except ConfigError as error:
            assert "makes SUMO write its settings" in str(error)  # noqa: PT017 - one of the two


@needs_sumo
def test_the_seed_is_ours_and_outputs_are_not_written(tmp_path: Path) -> None:
    users = USERS.replace('vClass="truck"', 'vClass="truck" sigma="0.9"')
    options = '<output><tripinfo-output value="trips.xml"/></output><random value="true"/>'
    source = configured(tmp_path, users=users, options=options)
    places = {
        (seed, number): list(run_sumo(source, slots=9, duration_s=10.0, seed=seed))[-1].position_m.tobytes()
        for seed in (1, 2)
        for number in range(2)
    }
    assert places[1, 0] == places[1, 1] != places[2, 0]
    assert not (tmp_path / "trips.xml").exists()


@needs_sumo
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("road.net.xml", "none.net.xml", r"File '.*none\.net\.xml' is not accessible"),
        ("users.rou.xml", "none.rou.xml", "is not accessible"),
        ("<end value", "<begn value", "begn"),
    ],
)
def test_what_sumo_refuses_is_told_in_its_own_words(old: str, new: str, told: str, tmp_path: Path) -> None:
    path = configured(tmp_path).path
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigError, match=told):
        survey_sumo(read_sumo_config(path), duration_s=5.0)


@needs_sumo
def test_what_sumo_leaves_out_with_a_warning_is_told(tmp_path: Path) -> None:
    late = '<vehicle id="late" type="lorry" route="across" depart="1"/></routes>'
    source = configured(tmp_path, users=USERS.replace("</routes>", late))
    (told,) = [note for note in survey_sumo(source, duration_s=5.0).notes if "warns" in note]
    assert "late" in told


@needs_sumo
def test_a_route_that_breaks_off_is_told_when_it_is_met(tmp_path: Path) -> None:
    broken = USERS.replace('type="two" route="across" depart="0"', 'type="two" route="gone" depart="3"')
    broken = broken.replace("<route id=", '<route id="gone" edges="inE inW"/><route id=', 1)
    with pytest.raises(ConfigError, match="has no valid route"):
        survey_sumo(configured(tmp_path, users=broken), duration_s=8.0)
