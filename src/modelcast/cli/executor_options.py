"""The options that say where a corpus is worked on."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclopts import Parameter

if TYPE_CHECKING:
    from modelcast.corpora.executors.base import AbstractExecutor

__all__ = ["ExecutorOptions"]


@Parameter(name="*")
@dataclass(frozen=True)
class ExecutorOptions:
    """Where work is done. They change no figure.

    Parameters
    ----------
    jobs
        Processes at a time; 0 for one a processor, 1 for none but this.
    cluster
        Work on a cluster of dask.distributed instead: 'local:N' for N of its workers on this machine, or the
        address of a scheduler, as 'tls://HOST:8786'. Needs the extra cluster. Trust it: whoever reaches a
        scheduler can run any code on its workers.
    memory
        What all processes that share the work on this machine may take together, as '2GiB' or '1500MB',
        shared out evenly. A partition that needs more fails and is named. No bound where not given.
    """

    jobs: int = 0
    cluster: str | None = None
    memory: str | None = None

    def executor(self) -> "AbstractExecutor":
        """The executor that they mean.

        Raises
        ------
        ConfigError
            Where they contradict one another, or a value is out of its range.
        MissingExtraError
            Where a cluster is asked for and its extra is not installed.
        """
        from modelcast.cli.octets import parse_octets
        from modelcast.core.exceptions import ConfigError

        memory_bytes = None if self.memory is None else parse_octets(self.memory, "--memory")
        if self.cluster is not None:
            from modelcast.corpora.executors.cluster import ClusterExecutor

            if self.jobs:
                raise ConfigError("--jobs is for this machine's processes: leave it out beside --cluster")
            return ClusterExecutor(self.cluster, memory_bytes)
        from modelcast.corpora.executors.here import HereExecutor
        from modelcast.corpora.executors.processes import ProcessExecutor

        processes = ProcessExecutor(self.jobs, memory_bytes)
        return HereExecutor() if processes.count == 1 and memory_bytes is None else processes

    def require_no_corpus(self) -> None:
        """Refuse what is for corpora alone.

        Raises
        ------
        ConfigError
            Where it is given.
        """
        from modelcast.core.exceptions import ConfigError

        for name, value in (("cluster", self.cluster), ("memory", self.memory)):
            if value is not None:
                raise ConfigError(
                    f"--{name} is for a corpus, a folder that modelcast ingest made: name one, alone"
                )

    def require_one_process(self, reason: str) -> None:
        """Refuse workers for what is not shared out.

        Parameters
        ----------
        reason
            Why it is not.

        Raises
        ------
        ConfigError
            Where some are asked for by name.
        """
        from modelcast.core.exceptions import ConfigError

        if self.cluster is not None or self.jobs > 1:
            option = "--jobs" if self.cluster is None else "--cluster"
            raise ConfigError(f"{option}: this is not shared among workers: {reason}")
