"""Which files of this folder are benchmarks, what each shows, and what the others are.

A benchmark measures cost and keeps it by `measured.record`. Studies answer a question about models in
messages or metres, or make a file once; they measure no cost, and nothing here runs them.
"""

from dataclasses import KW_ONLY, dataclass

__all__ = ["BENCHMARKS", "PARTS", "PROGRAMS", "STUDIES", "Benchmark"]

DATA, NS3 = "MODELCAST_DATA", "MODELCAST_NS3_PYTHON"
SECONDS, MINUTES, HOURS = "seconds", "minutes", "hours"


@dataclass(frozen=True, slots=True)
class Benchmark:
    """A script of this folder that measures.

    Parameters
    ----------
    name
        Of its file, without ``.py``.
    shows
        What it measures.
    peer
        What is measured beside it in the same run; empty where nothing is.
    takes
        On two idle cores: seconds (up to half a minute), minutes or hours.
    needs
        Environment variables that must name something.
    packages
        What must be importable, beyond the development packages; of alternatives, one is enough.
    wants
        Environment variables without which a peer is left out.
    words
        Its arguments; FOLDER stands for a folder of its own.
    quick
        Its arguments in a quick run; None where it is left out of one.
    """

    name: str
    shows: str
    peer: str
    takes: str
    _: KW_ONLY
    needs: tuple[str, ...] = ()
    packages: tuple[str, ...] = ()
    wants: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    quick: tuple[str, ...] | None = None


BENCHMARKS = (
    Benchmark(
        "arithmetic_limit",
        "distance of five jobs to what memory and arithmetic units can do",
        "kernels that only read and write, or only multiply and add",
        SECONDS,
        quick=(),
    ),
    Benchmark(
        "bsm_codec",
        "encode and decode basic safety messages, singly and in batches",
        "asn1tools",
        SECONDS,
        words=("--messages", "2000"),
        quick=("--messages", "200"),
    ),
    Benchmark(
        "psm_codec",
        "encode and decode personal safety messages",
        "the codec of basic ones",
        SECONDS,
        words=("--messages", "2000"),
        quick=("--messages", "200"),
    ),
    Benchmark("mbc_codec", "size, quantise, encode and decode model updates", "", SECONDS, quick=()),
    Benchmark(
        "signing", "sign and verify messages", "the bare signature and its verification", SECONDS, quick=()
    ),
    Benchmark(
        "gp_fit",
        "maximum-likelihood fit of a window of ten samples",
        "scikit-learn",
        MINUTES,
        needs=(DATA,),
        words=("--windows", "2000", "--restarted", "100"),
        quick=("--windows", "500", "--timed", "40", "--restarted", "20"),
    ),
    Benchmark(
        "gp_peers",
        "the same fit",
        "GPy, GPyTorch, tinygp, each where installed",
        MINUTES,
        needs=(DATA,),
        packages=("GPy", "gpytorch", "tinygp"),
        quick=("--windows", "500", "--batched", "50", "--single", "5"),
    ),
    Benchmark(
        "gp_expressions",
        "fit of all sums of two of the seven kernels",
        "scikit-learn",
        MINUTES,
        needs=(DATA,),
        words=("--timed", "30"),
        quick=("--timed", "3"),
    ),
    Benchmark("switching", "a step of a switching sub-model, and its training", "", MINUTES, needs=(DATA,)),
    Benchmark("numpy_sub_model", "a sub-model compiled", "the same in plain NumPy", MINUTES, quick=()),
    Benchmark("numpy_policy", "a policy compiled", "the same in plain NumPy", MINUTES),
    Benchmark("growth", "an evaluation by trips, a fleet by density and by threads", "", SECONDS, quick=()),
    Benchmark("rate_evaluation", "message rates of recorded trips", "", SECONDS, needs=(DATA,), quick=()),
    Benchmark(
        "free_receiver",
        "an evaluation with the free receiver",
        "one without it",
        SECONDS,
        quick=("--runs", "1"),
    ),
    Benchmark(
        "evaluate_command",
        "`modelcast --help` and `modelcast evaluate`, as a user meets them",
        "",
        MINUTES,
        needs=(DATA,),
    ),
    Benchmark("evaluate_memory", "peak memory of an evaluation by hours of driving", "", MINUTES),
    Benchmark("traffic", "built-in traffic, by vehicles and density", "", SECONDS, quick=()),
    Benchmark("safety_traffic", "traffic that makes conflicts", "", MINUTES),
    Benchmark("congestion", "J2945/1's rules and neighbour tables, by hosts", "", SECONDS, quick=()),
    Benchmark("dsrc_channel", "the radios, by nodes and messages", "ns-3", MINUTES, wants=(NS3,), quick=()),
    Benchmark("network_loop", "the closed loop, by vehicles", "", MINUTES),
    Benchmark("people_loop", "the closed loop with people", "the closed loop of vehicles alone", MINUTES),
    Benchmark(
        "safety_applications",
        "all safety applications of 1,000 hosts",
        "one of them in plain NumPy",
        SECONDS,
        quick=(),
    ),
    Benchmark(
        "local_dynamic_map",
        "predict all remotes, hear messages, by remotes",
        "one batched prediction",
        SECONDS,
        quick=(),
    ),
    Benchmark("plausibility", "checks of plausibility", "a map without checks", MINUTES, needs=(DATA,)),
    Benchmark(
        "node_tick",
        "a tick of a node with 1,000 remotes",
        "as many bare verifications",
        MINUTES,
        quick=("--ticks", "20", "--remotes", "200"),
    ),
    Benchmark("node_latency", "sample to another node's map", "", MINUTES),
    Benchmark("serve_step", "the step protocol", "its stations alone", SECONDS, quick=("--vehicles", "200")),
    Benchmark(
        "page_frames",
        "frames a second of the live page",
        "the page with nothing new",
        MINUTES,
        packages=("playwright",),
    ),
    Benchmark(
        "reading_memory",
        "time and memory of reading, converting and listing files of any order",
        "",
        MINUTES,
        words=("--rows", "4000000", "--tasks", "read", "--folder", "FOLDER"),
    ),
    Benchmark(
        "corpus",
        "`modelcast ingest`, by rows and processes",
        "",
        HOURS,
        needs=(DATA,),
        words=("--work", "FOLDER"),
    ),
    Benchmark(
        "corpus_evaluate",
        "`modelcast evaluate` on a corpus, by rows and processes",
        "",
        HOURS,
        needs=(DATA,),
        words=("--work", "FOLDER"),
    ),
    Benchmark(
        "corpus_jobs",
        "jobs over a corpus, lost workers, killed runs",
        "one process",
        HOURS,
        needs=(DATA,),
        words=("--work", "FOLDER"),
    ),
)

PROGRAMS = ("asn1tools", "scikit-learn", "GPy", "GPyTorch", "tinygp", "ns-3")
"""Peers that are programs of others; the rest is modelcast itself, done otherwise or in part."""

PARTS = {
    "corpus_rows": "rows for the corpus benchmarks",
    "limit_kernels": "kernels of arithmetic_limit",
    "machine": "what a benchmark ran on",
    "measured": "keeps what a benchmark has measured",
    "paired": "`make bench-paired`: this checkout against another one",
    "paired_scenarios": "what paired times",
    "payload_figure": "the figure of the payload studies",
    "peer_kernels": "kernels as scikit-learn's, for gp_expressions and for tests",
    "performance_page": "puts results.json into docs/performance.md and the pages that quote it",
    "quoted_results": "tables of results that other pages quote",
    "registry": "this list",
    "result_cells": "how a result is written in a table",
    "run_all": "`make bench`",
    "windows": "windows of recorded trips, for the gp benchmarks",
}
"""Files that others need, or that run others."""

STUDIES = {
    "context": "whether context tells what comes (docs/context.md)",
    "interacting": "which numbers the interacting multiple model should have (docs/models.md)",
    "name_training_trips": "writes the names of its training trips into the shipped profile",
    "payload": "bits and coefficients of a learned sub-model (docs/messages.md)",
    "payload_processes": "bits and coefficients of a Gaussian process (docs/messages.md)",
    "reception_table": "makes the table of the abstract radio",
    "traffic_table": "prints a finished sweep as docs/traffic-table.md",
    "trusted_horizon": "how far a sub-model should be trusted",
}
"""Scripts that answer a question about models, or make a file once; they measure no cost."""
