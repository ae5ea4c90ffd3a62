"""The sub-models of a bank as compiled loops take them.

What receivers hold of a sub-model is what the newest update said, or grows from update to update
(`absorb_member`). It grows while updates name the same sub-model as the one in use when they arrive, and
begins anew with another one and for whoever held nothing. So sender and receivers come to the same, losses
apart.
"""

from typing import NamedTuple

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix, FloatVector, IntMatrix, IntVector
from modelcast.models.address_kernels import fit_at, observe_at
from modelcast.models.trusted_kernels import predict_trusted

__all__ = ["NO_ABSORB", "Members", "absorb_member", "fit_member", "observe_member", "predict_member"]

NO_ABSORB = -1
"""In place of the address of ``absorb`` of a sub-model whose updates say all."""

_OBSERVE, _START, _FIRST, _END = range(4)


class Members(NamedTuple):
    """M sub-models in one process: it holds addresses, so it is made for a call and never kept.

    ``fits`` and ``predicts`` (M,) are addresses of point functions; ``constants`` (K,) holds the constants
    of member m from ``bounds[m]`` to ``bounds[m + 1]``; ``windows`` (M,) are the samples each needs; its
    parameters stand from ``offsets[m]`` to ``offsets[m + 1]`` in a row of all; ``trust`` (M, 2) is the
    trusted horizon of each and how long it goes on turning beyond [s]. ``streams`` (M, 4) are of each that
    carries state from sample to sample the address of its ``observe``, where its constants begin, and the
    first and the end of its columns; zeros of the others. ``absorbs`` (M,) are addresses of ``absorb``,
    `NO_ABSORB` of those whose updates say all.
    """

    fits: IntVector
    predicts: IntVector
    constants: FloatVector
    bounds: IntVector
    windows: IntVector
    offsets: IntVector
    trust: FloatMatrix
    streams: IntMatrix
    absorbs: IntVector


@kernel(inlined=True)
def fit_member(members: Members, m: int, window: FloatMatrix, out: FloatVector) -> None:
    """Fit member ``m`` to a window (n, 9) of its length, into ``out`` (P,)."""
    fit_at(members.fits[m], window, members.constants[members.bounds[m] : members.bounds[m + 1]], out)


@kernel
def observe_member(members: Members, m: int, before: FloatVector, sample: FloatVector) -> None:
    """Write the state of member ``m`` into its columns of a sample (C,), from the sample before or none."""
    observe, first, end = members.streams[m, _OBSERVE], members.streams[m, _FIRST], members.streams[m, _END]
    if end > first:
        constants = members.constants[members.streams[m, _START] : members.bounds[m + 1]]
        observe_at(observe, before, sample, constants, sample[first:end])


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


@kernel
def absorb_member(
    members: Members, m: int, new: FloatVector, moved: FloatVector, continues: bool, held: FloatVector
) -> None:
    """Take an update's own parameters (P,) of member ``m`` for what is held of it, ``held`` (P,).

    ``moved`` (3,) is the time [s] and the way east and north [m] from the update held before to this one;
    it is looked at where the update ``continues`` one of the same member.
    """
    if continues and members.absorbs[m] != NO_ABSORB:
        constants = members.constants[members.bounds[m] : members.bounds[m + 1]]
        observe_at(members.absorbs[m], new, moved, constants, held)
        return
    for i in range(new.size):
        held[i] = new[i]
