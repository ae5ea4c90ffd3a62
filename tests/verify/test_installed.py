"""Sdist and wheel hold what they should, and what is installed of them works on every Python here."""

import json
import re
import subprocess
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from verify.installing import ROOT, SUPPORTED, built, ended, interpreters, run, uv

pytestmark = pytest.mark.slow

VERSION: str = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]

SMOKE = """
import numpy as np
import modelcast

assert modelcast.__version__ == {version!r}, modelcast.__version__
assert "site-packages" in modelcast.__file__, modelcast.__file__
t_s = np.arange(200) * 0.1
path_m = np.stack([10.0 * t_s, 3.0 * np.sin(t_s)], axis=1)
trip = modelcast.build_trajectory("made/1", t_s, path_m, source="made")
modelcast.write_csv([trip], "trip.csv")
(read,) = modelcast.read_trips("trip.csv")
assert np.allclose(read.position_m, trip.position_m, atol=1e-3)
settings = modelcast.EvaluationSettings((0.5,), (0.0,), seeds=1, bank=modelcast.PAPER_BANK)
result = modelcast.evaluate(read, settings)
assert {{"mbc", "baseline"}} <= set(result.rates["policy"])
core = modelcast.BsmCore.from_values({{"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0}})
assert modelcast.decode_bsm(modelcast.encode_bsm(core)).core == core
assert modelcast.default_profile().identity
print("all is well")
"""


@pytest.fixture(scope="module", name="made")
def _made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return built(tmp_path_factory.mktemp("dist"))


def tracked(folder: str) -> set[str]:
    """Files of this checkout below a folder that git knows."""
    listed = subprocess.run(  # noqa: S603 - our own words
        ["git", "-C", str(ROOT), "ls-files", "--", folder],  # noqa: S607 - git of the path
        capture_output=True,
        text=True,
        check=True,
    )
    return {name for name in listed.stdout.splitlines() if (ROOT / name).is_file()}


def test_the_wheel_holds_the_package_whole_and_nothing_else(made: tuple[Path, Path]) -> None:
    with zipfile.ZipFile(made[1]) as wheel:
        names = set(wheel.namelist())
        licence = wheel.read(f"modelcast-{VERSION}.dist-info/licenses/LICENSE")
        metadata = wheel.read(f"modelcast-{VERSION}.dist-info/METADATA").decode()
    package = {name for name in names if not name.startswith(f"modelcast-{VERSION}.dist-info/")}
    assert package == {name.removeprefix("src/") for name in tracked("src/modelcast")}
    assert licence == (ROOT / "LICENSE").read_bytes()
    for needed in ("py.typed", "profiles/default.json", "dashboard/static/index.html", "messages/bsm.asn"):
        assert f"modelcast/{needed}" in package
    assert {f"Python :: {version}" for version in SUPPORTED} <= set(re.findall(r"Python :: 3\.\d+", metadata))


def test_the_sdist_holds_what_a_checkout_is_built_and_tested_with(made: tuple[Path, Path]) -> None:
    with tarfile.open(made[0]) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
        mode_and_owner = {(one.uid, one.gid) for one in sdist.getmembers()}
    wanted = {name for folder in ("src", "tests", "docs", "tools", "contrib") for name in tracked(folder)}
    wanted |= {
        "pyproject.toml",
        "LICENSE",
        "README.md",
        "CHANGELOG.md",
        "CITATION.cff",
        "SECURITY.md",
        "Makefile",
    }
    wanted |= {"requirements.lock", "requirements-dev.lock", "Containerfile"}
    assert wanted - names == set()
    assert not [name for name in names if name.startswith((".git/", ".venv", "out/", ".ci/"))]
    assert mode_and_owner == {(0, 0)}


@pytest.mark.parametrize("version", SUPPORTED)
def test_an_installed_wheel_works_with_the_locked_packages(
    version: str, made: tuple[Path, Path], tmp_path: Path
) -> None:
    """From the lock without SciPy, since that belongs to an extra; demo, smoke test, and what is refused."""
    interpreter = interpreters().get(version)
    if interpreter is None:
        pytest.skip(f"this machine has no Python {version}")
    place = tmp_path / "venv"
    uv("venv", "--quiet", "--python", interpreter, place)
    python, modelcast = place / "bin" / "python", place / "bin" / "modelcast"
    lock = ROOT / "requirements.lock"
    uv("pip", "install", "--quiet", "--python", python, "--require-hashes", "-r", lock)
    uv("pip", "uninstall", "--quiet", "--python", python, "scipy")
    uv("pip", "install", "--quiet", "--python", python, "--no-deps", made[1])
    uv("pip", "check", "--python", python)
    known = {"MODELCAST_CACHE_DIR": tmp_path / "cache", "HOME": tmp_path / "home"}
    assert run(modelcast, "--version", **known).strip() == VERSION
    smoke = f"import os; os.chdir({str(tmp_path)!r})\n" + SMOKE.format(version=VERSION)
    assert run(python, "-W", "error", "-c", smoke, **known).strip() == "all is well"
    if version == SUPPORTED[0]:  # the newest runs it in `test_container.py`; it compiles for most of a minute
        run(modelcast, "demo", "--duration", "90", "--out", tmp_path / "demo", **known)
        versions = json.loads((tmp_path / "demo" / "run.json").read_text(encoding="utf-8"))["versions"]
        assert versions["python"].startswith(version)
        assert "scipy" not in versions
    refused = ended(modelcast, "network", "--density", "25", "--out", tmp_path / "net", **known)
    assert refused.returncode == 2
    assert "needs scipy" in refused.stderr
    uv("pip", "uninstall", "--quiet", "--python", python, "modelcast")
    assert not modelcast.exists()
    assert not [one for one in place.rglob("*modelcast*") if "__pycache__" not in one.parts and one.is_file()]


def test_uv_and_pipx_install_run_upgrade_and_take_away(made: tuple[Path, Path], tmp_path: Path) -> None:
    home = tmp_path / "home"
    shared = {"HOME": home, "XDG_DATA_HOME": home / "data", "XDG_BIN_HOME": home / "bin"}
    known = {**shared, "MODELCAST_CACHE_DIR": tmp_path / "cache", "UV_LINK_MODE": "hardlink"}
    cache = uv("cache", "dir").strip()
    uv("tool", "install", "--quiet", made[1], UV_CACHE_DIR=cache, **shared)
    command = home / "bin" / "modelcast"
    assert run(command, "--version", **known).strip() == VERSION
    uv("tool", "install", "--quiet", "--force", f"{made[1]}[mcap]", UV_CACHE_DIR=cache, **shared)
    assert "extra mcap   present" in run(command, "doctor", **known)
    uv("tool", "uninstall", "--quiet", "modelcast", UV_CACHE_DIR=cache, **shared)
    assert not command.exists()

    pipx = {**known, "PIPX_HOME": home / "pipx", "PIPX_BIN_DIR": home / "bin", "UV_CACHE_DIR": cache}
    uv("tool", "run", "--quiet", "--from", "pipx==1.18.4", "pipx", "install", made[1], **pipx)
    assert run(command, "--version", **known).strip() == VERSION
    uv("tool", "run", "--quiet", "--from", "pipx==1.18.4", "pipx", "uninstall", "modelcast", **pipx)
    assert not command.exists()
