"""Claims about what is there to put a node on a machine: it parses, and names what exists."""

import re
import shlex
import shutil
import subprocess
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

from modelcast.cli.app import app, run
from modelcast.node.config import NodeConfig, read_config

ROOT = Path(__file__).parents[2]
CONTRIB = ROOT / "contrib"
INSTALLED = "/opt/modelcast/bin/modelcast"


def unit() -> dict[str, dict[str, list[str]]]:
    """The unit's sections; a name may stand several times."""
    found: dict[str, dict[str, list[str]]] = {}
    section: dict[str, list[str]] = {}
    for line in (CONTRIB / "modelcast-node.service").read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            section = found.setdefault(line.strip("[]"), {})
        elif line and not line.startswith("#"):
            name, _, value = line.partition("=")
            section.setdefault(name, []).append(value)
    return found


def instructions() -> list[tuple[str, str]]:
    """The container file's, continuation lines joined."""
    text = (CONTRIB / "Containerfile").read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [(line.split(maxsplit=1)[0], line.split(maxsplit=1)[1]) for line in lines]


def test_the_service_calls_what_the_command_line_takes() -> None:
    service = unit()["Service"]
    for name, command in (("ExecStartPre", "prepare"), ("ExecStart", "node")):
        program, *words = shlex.split(service[name][0])
        assert program == INSTALLED
        assert words == [command, "/etc/modelcast/node.toml"]
        app.parse_args(words, print_error=False, exit_on_error=False)


def test_the_service_runs_as_nobody_keeps_its_cache_and_starts_again() -> None:
    service = unit()["Service"]
    for name, value in (
        ("DynamicUser", "yes"),
        ("Restart", "always"),
        ("KillSignal", "SIGTERM"),
        ("ProtectSystem", "strict"),
        ("NoNewPrivileges", "yes"),
        ("CapabilityBoundingSet", ""),
    ):
        assert service[name] == [value]
    assert "MemoryDenyWriteExecute" not in service  # it would forbid what Numba does
    # The kernels' folder must be its user's alone (`modelcast.core.kernel_cache`), and outlive a start.
    assert service["CacheDirectoryMode"] == ["0700"]
    assert f"MODELCAST_CACHE_DIR=/var/cache/{service['CacheDirectory'][0]}" in service["Environment"]
    families = service["RestrictAddressFamilies"][0].split()
    assert {"AF_UNIX", "AF_INET", "AF_INET6", "AF_CAN"} <= set(families)


def test_systemd_takes_the_service(tmp_path: Path) -> None:
    program, there = shutil.which("systemd-analyze"), shutil.which("true")
    if program is None or there is None:
        pytest.skip("systemd-analyze is not installed")
    text = (CONTRIB / "modelcast-node.service").read_text(encoding="utf-8")
    path = tmp_path / "modelcast-node.service"
    path.write_text(text.replace(INSTALLED, there), encoding="utf-8")
    found = subprocess.run(  # noqa: S603 - our own words
        [program, "verify", str(path)], capture_output=True, text=True, check=False
    )
    about = [line for line in found.stderr.splitlines() if "modelcast-node" in line]
    assert (found.returncode, about) == (0, [])


def test_the_example_is_checked_and_shows_every_key(capsys: pytest.CaptureFixture[str]) -> None:
    path = CONTRIB / "node.toml"
    assert run(["node", str(path), "--check"]) == 0
    assert "all is as it should be" in capsys.readouterr().out
    # With every key taken in, it holds all tables and keys there are, and the defaults that it tells.
    whole = re.sub(r"^# (\w+ = )", r"\1", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    shown, own = tomllib.loads(whole), NodeConfig()
    assert set(shown) == {table.name for table in fields(NodeConfig)}
    set_here = tomllib.loads(path.read_text(encoding="utf-8"))
    for name, keys in shown.items():
        table = getattr(own, name)
        assert set(keys) == {key.name for key in fields(table)}, name
        for key, value in keys.items():
            default = getattr(table, key)
            if key in set_here[name] or default is None:
                continue
            assert value == (list(default) if isinstance(default, tuple) else default), key


def test_the_container_holds_what_its_file_names() -> None:
    found = instructions()
    for copied in (value for name, value in found if name == "COPY" and not value.startswith("--from")):
        *sources, _ = copied.split()
        assert all((ROOT / source).exists() for source in sources), copied
    words = dict(found)
    assert words["USER"] == "modelcast"
    assert words["STOPSIGNAL"] == "SIGTERM"
    (program,), arguments = (tomllib.loads(f"a = {words[name]}")["a"] for name in ("ENTRYPOINT", "CMD"))
    assert program == "modelcast"
    app.parse_args(arguments, print_error=False, exit_on_error=False)
    assert any(
        "--require-hashes -r requirements-node.lock" in value for name, value in found if name == "RUN"
    )
    assert ("COPY", f"contrib/node.toml {arguments[-1]}") in found


def test_the_container_is_healthy_by_the_figures_of_its_configuration() -> None:
    (health,) = (value for name, value in instructions() if name == "HEALTHCHECK")
    program, flag, code = tomllib.loads(f"a = {health.partition('CMD ')[2]}")["a"]
    assert (program, flag) == ("python", "-c")
    compile(code, "HEALTHCHECK", "exec")
    metrics = read_config(CONTRIB / "node.toml").metrics
    assert f"http://{metrics.host}:{metrics.port}/metrics" in code


def test_the_lock_of_a_node_holds_what_its_extra_names_in_the_versions_of_the_developers() -> None:
    def versions(name: str) -> dict[str, set[str]]:
        found: dict[str, set[str]] = {}
        for line in (ROOT / name).read_text(encoding="utf-8").splitlines():
            if match := re.match(r"([a-z0-9._-]+)==(\S+)", line):
                found.setdefault(match[1], set()).add(match[2])
        return found

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["node"]]
    node, developers = versions("requirements-node.lock"), versions("requirements-dev.lock")
    assert {re.split(r"[>=<]", one)[0].lower() for one in wanted} <= set(node)
    assert all(node[name] <= developers[name] for name in node)
