"""Tasks on a cluster of `dask.distributed`, used as a runner of tasks over files and for nothing else.

Whoever reaches a scheduler can run any code on its workers. ``local:N`` therefore listens on the loopback
interface alone, with TLS by certificates of its own that nobody else on the machine has. A cluster of others
is as safe as its network: take ``tls://`` addresses, with dask's own settings for certificates.
"""

# distributed has few types: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false, reportPrivateImportUsage=false

import logging
import os
import re
import secrets
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar, cast

from modelcast.core.compiling import Compiling, watch
from modelcast.core.exceptions import ConfigError, MissingExtraError
from modelcast.corpora.executors.base import TRIES, AbstractCrew, AbstractExecutor, Failed, LostWorkerError
from modelcast.corpora.executors.memory import processes_within
from modelcast.corpora.executors.one_thread import ONE_THREAD
from modelcast.corpora.executors.undisturbed import undisturbed
from modelcast.corpora.executors.versions import PACKAGES, difference, own_versions, worker_versions

try:
    import dask
    from distributed import Client, Future, KilledWorker, LocalCluster, as_completed, get_worker
except ImportError as error:
    raise MissingExtraError("--cluster", "cluster") from error

__all__ = ["ClusterCrew", "ClusterExecutor"]

Work = TypeVar("Work")
Found = TypeVar("Found")

_LOCAL = re.compile(r"local:([1-9][0-9]{0,3})")
_REMOTE = re.compile(r"(tcp|tls)://[^\s/:]+(:[^\s/:]+)*:[0-9]{1,5}")
_HOST = "127.0.0.1"
_PATIENCE_S = 20
_LOOK_S = 0.02
_GONE_S = 120.0
_AHEAD = 2  # tasks a worker that the scheduler knows of: one is under way, one waits for it

_LOCAL_SETTINGS = {
    "distributed.nanny.pre-spawn-environ": ONE_THREAD,
    "distributed.scheduler.allowed-failures": TRIES - 1,
    "distributed.scheduler.worker-saturation": 1.0,  # so that a lost worker is blamed on one task alone
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}


class _OtherVersionError(ConfigError):
    """A worker is of other versions: it would fail every task it is given, so that the run ends."""


@dataclass(frozen=True, slots=True)
class ClusterExecutor(AbstractExecutor):
    """A cluster, by its scheduler's address.

    Parameters
    ----------
    address
        ``local:N`` for N processes of this machine, or ``tcp://HOST:PORT`` or ``tls://HOST:PORT``.
    memory_bytes
        With ``local:N``, what all workers together may take, shared out evenly; None for no bound.

    Raises
    ------
    ConfigError
        Where the address is none, the memory is not enough for so many, or a bound is given for workers that
        others started.
    """

    address: str
    memory_bytes: int | None = None

    def __post_init__(self) -> None:
        if not (_LOCAL.fullmatch(self.address) or _REMOTE.fullmatch(self.address)):
            raise ConfigError(
                "--cluster must be local:N, or a scheduler's address as tcp://HOST:PORT or tls://HOST:PORT, "
                f"got {self.address!r}"
            )
        if self.memory_bytes is not None and not self._local:
            raise ConfigError(
                "--memory bounds workers of this machine alone: those of a cluster are started with dask's "
                "own --memory-limit"
            )
        if self.memory_bytes is not None:
            processes_within(self.memory_bytes, self._local)

    @property
    def _local(self) -> int:
        """Processes of this machine; 0 for a cluster of others."""
        found = _LOCAL.fullmatch(self.address)
        return int(found[1]) if found else 0

    @property
    def worker_bytes(self) -> int | None:
        """An even share of what ``local:N`` may take; what others' workers may take is not known."""
        return None if self.memory_bytes is None else self.memory_bytes // self._local

    @contextmanager
    def start(self) -> Generator[AbstractCrew]:
        """Start the workers of ``local:N``, or go to those there are, once their versions are seen to fit."""
        with ExitStack() as stack:
            if self._local:
                stack.enter_context(dask.config.set(_LOCAL_SETTINGS))
                with undisturbed():
                    cluster = _local_cluster(self._local, self.worker_bytes)
                where: Any = stack.enter_context(cluster)
            else:
                where = self.address
            client = stack.enter_context(_client(where, self.address))
            crew = ClusterCrew(client, own=self._local > 0)
            crew.require_fit()
            yield crew


def _local_cluster(count: int, worker_bytes: int | None) -> LocalCluster:
    """Processes of this machine that listen to nobody else."""
    return LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        processes=True,
        host=_HOST,
        security=True,
        dashboard_address=f"{_HOST}:0",
        worker_dashboard_address=f"{_HOST}:0",
        memory_limit=0 if worker_bytes is None else worker_bytes,
        silence_logs=logging.CRITICAL,
    )


def _client(where: Any, address: str) -> Client:
    """Go to a scheduler."""
    try:
        client = Client(where, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, TypeError, ValueError, RuntimeError) as error:  # TypeError: tls:// without certificates
        raise ConfigError(f"--cluster {address}: no scheduler is reached there: {error}") from error
    return client


class ClusterCrew(AbstractCrew):
    """The workers of a cluster.

    Parameters
    ----------
    client
        Connected.
    own
        Whether its workers were started for this run: then nobody else replaces them.
    """

    def __init__(self, client: Client, *, own: bool = False) -> None:
        self._client: Any = client
        self._own = own

    def as_done(
        self, function: Callable[[Work], Found], work: Iterable[Work]
    ) -> Iterator[tuple[Work, Found | Failed]]:
        """A task whose worker is lost is begun again on another, as often as the scheduler allows."""
        left = iter(work)
        checked = partial(_checked, dict(worker_versions()), function)
        waiting: dict[Future[Any], Work] = {}
        done = as_completed(loop=self._client.loop)

        def submit() -> None:
            """Give the scheduler some more."""
            room = _AHEAD * max(len(self._client.nthreads()), 1) - len(waiting)
            for one in islice(left, max(room, 0)):
                future = self._client.submit(checked, one, pure=False)
                waiting[future] = one
                done.add(future)

        submit()
        try:
            while waiting:
                if self._own:
                    self._look_after(done)
                future = next(done)
                one = waiting.pop(future)
                answer = self._answer(future)
                future.release()
                submit()
                yield one, cast("Found | Failed", answer)
        finally:
            self._client.cancel(list(waiting), force=True)

    def require_shared(self, folders: Sequence[Path]) -> None:
        """Workers must see a file that this process writes for a moment, and this process's others."""
        for folder in folders:
            token = folder / f".seen-{secrets.token_hex(8)}" if os.access(folder, os.W_OK) else None
            try:
                if token is not None:
                    token.touch()
                looked: dict[str, object] = self._client.run(os.path.exists, str(token or folder))
            finally:
                if token is not None:
                    token.unlink(missing_ok=True)
            blind = sorted(worker for worker, seen in looked.items() if seen is not True)
            if blind:
                raise ConfigError(
                    f"worker {blind[0]} does not see {folder}: all machines of a cluster need the same files "
                    "under the same names, as on a shared file system"
                )

    def require_fit(self) -> None:
        """Refuse a cluster with no worker, or with one that is of other versions or runs threads.

        Raises
        ------
        ConfigError
            Naming the first.
        """
        try:
            self._client.wait_for_workers(1, timeout=_PATIENCE_S)
        except TimeoutError as error:
            raise ConfigError(f"the cluster has no worker after {_PATIENCE_S} s: start some") from error
        for worker, threads in sorted(self._client.nthreads().items()):
            if threads != 1:
                raise ConfigError(
                    f"worker {worker} runs {threads} tasks at a time in one process: start it with "
                    "--nthreads 1, and --nworkers as many as it has processors"
                )
        ours = own_versions()
        for worker, theirs in sorted(self._versions().items()):
            _require_same(worker, theirs, {name: ours[name] for name in theirs})
        for worker, theirs in sorted(self._client.run(worker_versions).items()):
            _require_same(worker, theirs, worker_versions())

    def _versions(self) -> dict[str, dict[str, str]]:
        """Packages' versions by worker; asked without modelcast, which may be missing there."""
        found: dict[str, dict[str, str]] = {}
        for name in PACKAGES:
            said: dict[str, object] = self._client.run(metadata.version, name, on_error="return")
            for worker, version in said.items():
                found.setdefault(worker, {})[name] = version if isinstance(version, str) else "none"
        return found

    def _look_after(self, done: Any) -> None:
        """Wait for the next task that ends, as long as there is a worker or may be one again."""
        gone_s = 0.0
        while not done.has_ready():
            time.sleep(_LOOK_S)
            gone_s += _LOOK_S
            if gone_s >= _PATIENCE_S and self._client.nthreads():
                gone_s = 0.0
            elif gone_s >= _GONE_S:
                raise ConfigError("all workers are gone and none came back: what is done is kept, run again")

    def _answer(self, future: Future[Any]) -> object:
        """What a task gave."""
        try:
            return future.result()
        except KilledWorker as error:
            return Failed(LostWorkerError(error.allowed_failures + 1, f"at {error.last_worker.address}"))
        except _OtherVersionError:
            raise
        except CancelledError as error:
            raise ConfigError("the cluster's scheduler is gone: what is done is kept, run again") from error
        except Exception as error:  # noqa: BLE001 - whatever it is, it costs this task alone
            return Failed(error)


def _require_same(worker: str, theirs: Mapping[str, str], ours: Mapping[str, str]) -> None:
    """Refuse a worker of other versions."""
    differs = difference(worker, theirs, ours)
    if differs:
        raise _OtherVersionError(f"{differs}: install the same on all machines")


def _checked(versions: Mapping[str, str], function: Callable[[Work], Found], one: Work) -> Found:
    """What a function gives on a worker that may have come later than the check."""
    _require_same(get_worker().address, worker_versions(), versions)
    watch(_unheard)
    return function(one)


def _unheard(_: Compiling) -> None:
    """Takes what is compiled on a worker, whose terminal is another's."""
