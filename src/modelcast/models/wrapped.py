"""What sub-models that go round another have in common."""

from dataclasses import dataclass
from typing import Annotated

from modelcast.core.rules import One
from modelcast.models.base import AbstractSubModel
from modelcast.models.payload import PayloadLayout

__all__ = ["AbstractWrapped", "unwrapped"]


@dataclass(frozen=True, slots=True)
class AbstractWrapped(AbstractSubModel):
    """A sub-model round another: whatever it does not say is the other's.

    Parameters
    ----------
    model
        The sub-model inside.
    """

    model: Annotated[AbstractSubModel, One((AbstractSubModel,), "a sub-model")]

    @property
    def name(self) -> str:
        """The model's."""
        return self.model.name

    @property
    def window(self) -> int:
        """The model's."""
        return self.model.window

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """The model's."""
        return self.model.parameter_names

    @property
    def payload_parameters(self) -> int:
        """The model's."""
        return self.model.payload_parameters

    @property
    def payload_layout(self) -> PayloadLayout | None:
        """The model's."""
        return self.model.payload_layout

    @property
    def held_parameters(self) -> tuple[str, ...]:
        """The model's."""
        return self.model.held_parameters

    @property
    def predicts_by_parameters(self) -> bool:
        """The model's."""
        return self.model.predicts_by_parameters

    @property
    def trusted_horizon_s(self) -> float:
        """The model's."""
        return self.model.trusted_horizon_s

    @property
    def trusted_turn_s(self) -> float:
        """The model's."""
        return self.model.trusted_turn_s


def unwrapped(member: AbstractSubModel) -> AbstractSubModel:
    """Return the sub-model inside all that goes round it.

    Parameters
    ----------
    member
        Any sub-model.
    """
    while isinstance(member, AbstractWrapped):
        member = member.model
    return member
