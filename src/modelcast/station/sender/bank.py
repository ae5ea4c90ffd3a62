"""A sender's bank made ready: point functions, codes and sizes as compiled steps take them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.bsm_batch import CORE_MEANING
from modelcast.messages.bsm_fields import CORE_INDEX
from modelcast.messages.code_table import MOTION_FIELDS, code_table
from modelcast.messages.codes_kernels import COLUMNS
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.models.members import ReadyBank
from modelcast.models.payload import CORE_PARAMETERS
from modelcast.station.policy.guard import FREE_GUARDS, GUARD
from modelcast.station.sender.fitting_kernels import SenderModels
from modelcast.station.sender.motion_kernels import MOTION, PartOne

__all__ = ["SenderBank"]


@dataclass(frozen=True, slots=True)
class SenderBank:
    """A bank for one sampling interval, as a sender fits it and as its receivers hold it.

    It may go to another process: addresses are asked for where compiled steps are called (`models`).

    Parameters
    ----------
    bank
        The sub-models in the forms that messages carry; one that does with a single sample is added last
        where there is none, and then serves only for want of another.
    ready
        Their point functions.
    table
        What a message can say of their parameters, (P, `codes_kernels.COLUMNS`); empty where they are held as
        they were fitted.
    sizes
        Bytes of an update by the sub-model in use, (M,).
    fallback
        The member added, -1 where none was.
    dt_s
        Sampling interval [s].
    selector
        Predicts which member lasts; None for none.
    """

    bank: Bank
    ready: ReadyBank
    table: FloatArray
    sizes: IntArray
    fallback: int
    dt_s: float
    selector: Selector | None = None

    @classmethod
    def of(
        cls,
        bank: Bank,
        dt_s: float,
        *,
        quantised: bool = True,
        identify: str = "never",
        sizes: SizeModel | None = None,
        selector: Selector | None = None,
    ) -> "SenderBank":
        """Make a bank ready.

        Parameters
        ----------
        bank
            Its sub-models.
        dt_s
            Sampling interval [s].
        quantised
            Whether parameters go through the codes of the wire; else they stay as fitted.
        identify
            The policy's rule, which says whether all parameters are sent.
        sizes
            Bytes of messages; None for the codec's.
        selector
            Predicts which member lasts.

        Raises
        ------
        ValueError
            Where the selector was trained for another bank.
        """
        carried = bank.carried() if quantised else bank
        whole = carried.complete()
        if selector is not None:
            selector.check_members(tuple(member.name for member in whole.members))
        return cls(
            whole,
            ReadyBank.of(whole, dt_s),
            code_table(whole).rows if quantised else np.empty((0, COLUMNS)),
            (SizeModel() if sizes is None else sizes).each_update_bytes(whole, identify),
            -1 if whole is carried else len(carried.members),
            dt_s,
            selector,
        )

    @property
    def guards(self) -> tuple[int, ...]:
        """The members that guard a sender, constant velocity first; empty where the bank has none of its own.

        Raises
        ------
        ValueError
            Where a bank of several lacks constant velocity.
        """
        if len(self.bank.members) == 1 or self.fallback == 1:
            return ()  # one sub-model and what stands in for it: nothing to guard
        place = self.bank.place_of(GUARD)
        if place == self.fallback:
            raise ValueError(f"start 'guarded' needs {GUARD} as a member of its own: add it")
        return (place, *((self.free,) if self.free >= 0 else ()))

    @property
    def free(self) -> int:
        """The member whose sender states its own estimates in Part I (`FREE_GUARDS`), -1 for none."""
        names = [member.name for member in self.bank.members]
        return next((names.index(name) for name in FREE_GUARDS if name in names), -1)

    @property
    def part_one(self) -> PartOne:
        """How messages carry the motion that members say."""
        places = np.full((len(self.bank.members), MOTION), -1, dtype=np.int64)
        for own, member, first in zip(places, self.bank.members, self.bank.offsets.tolist(), strict=False):
            for which, name in enumerate(CORE_PARAMETERS):
                if name in member.parameter_names:
                    own[which] = first + member.parameter_names.index(name)
        fields = [CORE_INDEX[name] for name in MOTION_FIELDS] if self.table.size else []
        return PartOne(places, self.ready.offsets, np.ascontiguousarray(CORE_MEANING[fields]))

    def models(self, guards: Sequence[int] = ()) -> SenderModels:
        """What compiled steps take; it means something in this process alone.

        Parameters
        ----------
        guards
            The members that guard lanes.
        """
        selector = self.selector
        return SenderModels(
            self.ready.members,
            self.table,
            self.sizes,
            self.fallback,
            guards[0] if guards else -1,
            self.free,
            0 if selector is None else selector.address,
            1 if selector is None else selector.window_at(self.dt_s),
            self.dt_s,
            self.part_one,
        )
