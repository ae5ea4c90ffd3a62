"""What a cluster adds: whom it listens to, which workers it refuses by name, and what it says."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import modelcast
from modelcast.cli.executor_options import ExecutorOptions
from modelcast.core.exceptions import ConfigError, MissingExtraError
from worker_tasks import doubled

distributed = pytest.importorskip("distributed", reason="the extra `cluster` brings dask.distributed")
psutil = pytest.importorskip("psutil", reason="distributed brings psutil")

from modelcast.corpora.executors.cluster import ClusterExecutor  # noqa: E402 - of the extra

LOOPBACK = "127.0.0.1"


@contextmanager
def other_cluster(workers: int, threads: int = 1) -> Iterator[str]:
    """A cluster of others on this machine, without certificates; yields its scheduler's address."""
    with distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=threads,
        processes=False,
        protocol="tcp",
        host=LOOPBACK,
        dashboard_address=f"{LOOPBACK}:0",
    ) as cluster:
        yield cluster.scheduler_address


@contextmanager
def other_worker(address: str, first_on_path: Path) -> Iterator[None]:
    """A worker of another process that finds packages in a folder first."""
    source = Path(modelcast.__file__).parents[1]
    path = os.pathsep.join([str(first_on_path), str(source), str(Path(__file__).parents[1])])
    words = [address, "--nthreads", "1", "--no-nanny", "--host", LOOPBACK, "--no-dashboard"]
    process = subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-m", "distributed.cli.dask_worker", *words],
        env={**os.environ, "PYTHONPATH": path},
        cwd=first_on_path,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        process.kill()
        process.wait()


def test_a_local_cluster_listens_on_loopback_alone_and_with_certificates() -> None:
    def listening(process: Any) -> set[tuple[int, str, int]]:
        found = process.net_connections(kind="inet")
        return {(process.pid, *one.laddr) for one in found if one.status == psutil.CONN_LISTEN}

    us = psutil.Process()
    before = listening(us)
    with ClusterExecutor("local:1").start() as crew:
        assert list(crew.as_done(doubled, [1])) == [(1, 2)]
        sockets = set[tuple[int, str, int]]()
        for process in (us, *us.children(recursive=True)):
            sockets |= listening(process)
        sockets -= before
        assert len({pid for pid, _, _ in sockets}) == 2
        assert {host for _, host, _ in sockets} == {LOOPBACK}
        known: Any = crew
        assert [address[:6] for address in known._client.nthreads()] == ["tls://"]
    assert listening(us) == before


@pytest.mark.slow
def test_a_cluster_of_others_is_used_by_its_address() -> None:
    with other_cluster(2) as address, ClusterExecutor(address).start() as crew:
        assert sorted(crew.as_done(doubled, range(4))) == [(0, 0), (1, 2), (2, 4), (3, 6)]


@pytest.mark.parametrize("package", ["numpy", pytest.param("modelcast", marks=pytest.mark.slow)])
def test_a_worker_of_another_version_is_refused_by_name(tmp_path: Path, package: str) -> None:
    about = tmp_path / f"{package}-0.0.1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 0.0.1\n")
    with other_cluster(0) as address, other_worker(address, tmp_path):
        said = refusal(address)
    assert said.startswith(f"worker tcp://{LOOPBACK}:")
    assert f" has {package} 0.0.1, this machine " in said
    assert said.endswith(": install the same on all machines")


@pytest.mark.slow
def test_a_worker_of_another_version_that_joins_later_ends_the_run_by_name(tmp_path: Path) -> None:
    about = tmp_path / "numpy-0.0.1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: numpy\nVersion: 0.0.1\n")
    with other_cluster(1) as address, ClusterExecutor(address).start() as crew:
        known: Any = crew
        with other_worker(address, tmp_path):
            known._client.wait_for_workers(2, timeout=60)
            with pytest.raises(ConfigError, match=r"worker tcp://.* has numpy 0\.0\.1, this machine"):
                list(crew.as_done(doubled, range(50)))


@pytest.mark.slow
def test_a_worker_of_other_sources_under_the_same_version_is_refused_by_name(tmp_path: Path) -> None:
    folder = Path(modelcast.__file__).parent
    shutil.copytree(folder, tmp_path / "modelcast", ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "modelcast" / "study" / "rules.py").open("a") as file:
        file.write("# another day's\n")
    with other_cluster(0) as address, other_worker(address, tmp_path):
        said = refusal(address)
    assert said.startswith(f"worker tcp://{LOOPBACK}:")
    assert " has modelcast's sources " in said


def test_a_worker_with_threads_is_refused_by_name() -> None:
    with other_cluster(1, threads=3) as address:
        assert "runs 3 tasks at a time in one process: start it with --nthreads 1" in refusal(address)


@pytest.mark.slow
def test_a_worker_that_sees_other_files_is_refused_by_name(tmp_path: Path) -> None:
    with other_cluster(1) as address, ClusterExecutor(address).start() as crew:
        crew.require_shared([tmp_path])
        with pytest.raises(ConfigError, match=rf"worker tcp://{LOOPBACK}:\d+ does not see .*none: all mach"):
            crew.require_shared([tmp_path / "none"])


@pytest.mark.parametrize(
    "address", ["local:0", "local:-1", "local", "10.0.0.7:8786", "http://10.0.0.7:8786", "tcp://10.0.0.7", ""]
)
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(ConfigError, match=r"--cluster must be local:N, or a scheduler's address"):
        ClusterExecutor(address)


def test_memory_of_other_machines_is_not_ours_to_bound() -> None:
    with pytest.raises(ConfigError, match="dask's own --memory-limit"):
        ClusterExecutor("tcp://10.0.0.7:8786", 2**30)


def refusal(address: str) -> str:
    """What is said of a cluster that is refused."""
    with pytest.raises(ConfigError) as refused, ClusterExecutor(address).start():
        pass
    return str(refused.value)


def test_without_the_extra_one_line_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, ClusterExecutor.__module__)
    with pytest.raises(MissingExtraError) as missing:
        ExecutorOptions(cluster="local:2").executor()
    assert str(missing.value).startswith("--cluster needs cryptography and distributed: ")
    assert str(missing.value).endswith(" install cryptography distributed")
