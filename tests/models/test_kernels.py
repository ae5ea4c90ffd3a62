"""Kernels as values: what sums and products mean, and that each kernel is scikit-learn's of that name."""

import itertools
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.models.gp.kernels import (
    LEAVES,
    AbstractKernel,
    Linear,
    Matern32,
    Periodic,
    Product,
    Rbf,
    Sum,
    kernel_from_text,
)
from modelcast.models.gp.kernels.base import AbstractLeaf
from modelcast.models.gp.kernels.text import MOST_CHARACTERS, MOST_DEPTH, MOST_LEAVES

PEERS = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "peer_kernels.py"))
T_S = np.arange(-9, 1) * 0.1
EXPRESSIONS = (
    *LEAVES,
    *(f"{a}{join}{b}" for a, b in itertools.combinations(LEAVES, 2) for join in "+*"),
    "(linear+rq)*(matern12+periodic)+rbf*linear",
)


def kernels(most: int = MOST_LEAVES) -> st.SearchStrategy[AbstractKernel]:
    """Trees of a few leaves."""
    leaves = st.sampled_from([cls() for cls in LEAVES.values()])

    def joined(parts: st.SearchStrategy[AbstractKernel]) -> st.SearchStrategy[AbstractKernel]:
        pair = st.tuples(parts, parts)
        return pair.map(Sum) | pair.map(Product)

    return st.recursive(leaves, joined, max_leaves=most).filter(lambda one: count(one) <= most)


def count(kernel: AbstractKernel) -> int:
    """Leaves of a kernel."""
    return sum(1 for _ in kernel.places())


def some_values(kernel: AbstractKernel, seed: int) -> np.ndarray:
    """Hyper-parameters between 0.5 and 2."""
    return np.random.default_rng(seed).uniform(0.5, 2.0, len(kernel.hyperparameters))


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_covariances_are_scikit_learns(expression: str) -> None:
    kernel = kernel_from_text(expression)
    values = some_values(kernel, 1)
    peer = PEERS["peer_of"](expression, np.append(values, 1e-9))
    theirs = peer(T_S[:, None], np.array([[0.3], [2.0]]))
    np.testing.assert_allclose(kernel.at(values, T_S[:, None], np.array([0.3, 2.0])), theirs, rtol=1e-12)


def test_a_sum_adds_and_a_product_multiplies() -> None:
    a, b = Rbf(0.7, variance=2.0), Periodic(1.5, 0.8, variance=3.0)
    t, u = T_S[:, None], T_S
    np.testing.assert_array_equal((a + b)(t, u), a(t, u) + b(t, u))
    np.testing.assert_array_equal((a * b)(t, u), a(t, u) * b(t, u))


def test_a_product_has_one_scale_and_a_sum_one_a_part() -> None:
    names = {
        "linear+rbf": ["linear_1_variance_m2", "rbf_2_variance_m2", "rbf_2_lengthscale_s"],
        "linear*rbf": ["linear_1_variance_m2", "rbf_2_lengthscale_s"],
        "matern32*(linear+rbf)": [
            "matern32_1_variance_m2",
            "matern32_1_lengthscale_s",
            "rbf_3_variance_ratio",
            "rbf_3_lengthscale_s",
        ],
    }
    for expression, wanted in names.items():
        assert [one.name for one in kernel_from_text(expression).hyperparameters] == wanted


@given(kernels(), st.integers(0, 99))
def test_no_two_hyperparameters_do_the_same(kernel: AbstractKernel, seed: int) -> None:
    """Scaling all variances in m² scales the covariance, and nothing else is a scale of the whole."""
    values = some_values(kernel, seed)
    scales = np.array([one.name.endswith("variance_m2") for one in kernel.hyperparameters])
    t, u = T_S[:, None], T_S
    twice = kernel.at(np.where(scales, 2.0 * values, values), t, u)
    np.testing.assert_allclose(twice, 2.0 * kernel.at(values, t, u), rtol=1e-12)


@given(kernels(), st.integers(0, 99))
def test_multiplied_out_it_is_the_same_kernel(kernel: AbstractKernel, seed: int) -> None:
    filled = kernel.with_values(list(some_values(kernel, seed)))
    leaves = [place.leaf for place in filled.places()]
    t, u = T_S[:, None], T_S
    total = sum(np.prod([leaves[leaf](t, u) for leaf in term], axis=0) for term in filled.terms())
    np.testing.assert_allclose(total, filled(t, u), rtol=1e-12)


@given(kernels(), st.integers(0, 99))
def test_covariances_are_symmetric_and_not_negative(kernel: AbstractKernel, seed: int) -> None:
    covariance = kernel.at(some_values(kernel, seed), T_S[:, None], T_S)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-14)
    found = np.linalg.eigvalsh(covariance)
    assert found[0] > -1e-12 * found[-1]


@given(kernels())
def test_the_canonical_text_reads_as_the_same_kernel(kernel: AbstractKernel) -> None:
    assert kernel_from_text(str(kernel)) == kernel


@given(kernels(4))
def test_spaces_and_needless_parentheses_count_for_nothing(kernel: AbstractKernel) -> None:
    assert kernel_from_text(f" ( {str(kernel).replace('+', ' + ')} )") == kernel


def test_a_product_binds_closer_than_a_sum() -> None:
    assert kernel_from_text("linear+rbf*matern32") == Linear() + Rbf() * Matern32()
    assert kernel_from_text("(linear+rbf)*matern32") == (Linear() + Rbf()) * Matern32()


@pytest.mark.parametrize(
    ("text", "place", "why"),
    [
        ("", 1, "a kernel is missing; there are linear, rbf"),
        ("linear+", 8, "a kernel is missing"),
        ("linear+*rbf", 8, r"expected a kernel or \(, got '\*'"),
        ("linear+rfb", 8, "no kernel is named 'rfb'; there are .*rq and periodic"),
        ("(rbf", 5, r"a \) is missing"),
        ("(rbf rq)", 6, r"expected \), got 'rq'"),
        ("rbf)", 4, r"expected \+ or \* or the end, got '\)'"),
        ("rbf-rbf", 4, "got '-'"),
        ("RBF", 1, "no kernel is named 'RBF'"),
        ("rbf+\N{GREEK SMALL LETTER ALPHA}", 5, "no kernel is named"),
        ("+".join(["rbf"] * (MOST_LEAVES + 1)), 25, f"at most {MOST_LEAVES} kernels"),
        (
            "(" * (MOST_DEPTH + 1) + "rbf" + ")" * (MOST_DEPTH + 1),
            MOST_DEPTH + 1,
            f"at most {MOST_DEPTH} deep",
        ),
    ],
)
def test_what_is_no_kernel_is_refused_with_the_place(text: str, place: int, why: str) -> None:
    with pytest.raises(ValueError, match=rf"^character {place} of .*{why}"):
        kernel_from_text(text)


def test_a_long_text_is_refused_before_it_is_read() -> None:
    with pytest.raises(ValueError, match=f"at most {MOST_CHARACTERS} characters, got 100000"):
        kernel_from_text("(" * 100_000)


@given(st.text(alphabet="()+* rbfqlinea12", max_size=MOST_CHARACTERS + 9))
def test_any_text_is_a_kernel_or_a_value_error(text: str) -> None:
    try:
        kernel = kernel_from_text(text)
    except ValueError:
        return
    assert count(kernel) <= MOST_LEAVES


def test_hyperparameters_of_another_number_are_refused() -> None:
    kernel = kernel_from_text("linear+rbf")
    with pytest.raises(ValueError, match="3 hyper-parameters"):
        kernel.at(np.ones(2), T_S, T_S)
    with pytest.raises(ValueError, match="3 hyper-parameters, got 4"):
        kernel.with_values([1.0] * 4)


def test_every_leaf_has_a_name_and_a_code_of_its_own(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    assert set(LEAVES.values()) == concrete_classes(AbstractLeaf)
    codes = [cls.code for cls in LEAVES.values()]
    assert sorted(codes) == list(range(len(LEAVES)))
