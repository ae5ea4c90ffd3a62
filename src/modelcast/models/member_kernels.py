"""The sub-models of a bank as compiled loops take them."""

from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntVector
from modelcast.models.address_kernels import fit_at
from modelcast.models.trusted_kernels import predict_trusted

__all__ = ["Members", "fit_member", "predict_member"]


class Members(NamedTuple):
    """M sub-models in one process: it holds addresses, so it is made for a call and never kept.

    ``fits`` and ``predicts`` (M,) are addresses of point functions; ``constants`` (K,) holds the constants
    of member m from ``bounds[m]`` to ``bounds[m + 1]``; ``windows`` (M,) are the samples each needs; its
    parameters stand from ``offsets[m]`` to ``offsets[m + 1]`` in a row of all; ``trust`` (M, 2) is the
    trusted horizon of each and how long it goes on turning beyond [s].
    """

    fits: IntVector
    predicts: IntVector
    constants: FloatVector
    bounds: IntVector
    windows: IntVector
    offsets: IntVector
    trust: FloatMatrix


@kernel(inlined=True)
def fit_member(members: Members, m: int, window: FloatMatrix, out: FloatVector) -> None:
    """Fit member ``m`` to a window (n, 7) of its length, into ``out`` (P,)."""
    fit_at(members.fits[m], window, members.constants[members.bounds[m] : members.bounds[m + 1]], out)


@kernel(inlined=True)
def predict_member(members: Members, m: int, parameters: FloatVector, age_s: float, out: FloatVector) -> None:
    """Predict with member ``m`` from its own parameters (P,), into ``out`` (2,); see `predict_trusted`."""
    predict_trusted(
        members.predicts[m],
        parameters,
        age_s,
        members.constants[members.bounds[m] : members.bounds[m + 1]],
        members.trust[m, 0],
        members.trust[m, 1],
        out,
    )
