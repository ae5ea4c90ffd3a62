"""Claims about the server: over a socket it is the session, and no client hurts another."""

import numpy as np

from modelcast.node.serving.client import StepClient
from modelcast.node.serving.schema import named_values
from modelcast.runtime.external.exchange import SessionSettings
from modelcast.runtime.external.session import Session

from ...convoy import Convoy  # noqa: TID252 - tests are no package
from .conftest import Served

SETTINGS = SessionSettings(4, capacity=50, seed=3)


def _same(one: object, other: object) -> None:
    for name, value in named_values(one).items():
        np.testing.assert_array_equal(value, getattr(other, name), err_msg=name)


def test_over_a_socket_it_is_the_session(served: Served) -> None:
    near, far = Convoy(4), Convoy(4)
    session = Session(SETTINGS)
    with StepClient(SETTINGS, path=served.path) as client:
        for number in range(40):
            here, there = session.step(near.step(number)), client.step(far.step(number))
            _same(here, there)
            near.carry(here)
            far.carry(there)
            _same(session.believe(near.vehicle, 0.1 * number), client.believe(far.vehicle, 0.1 * number))
            _same(
                session.warnings(near.vehicle, ["fcw", "ima"]), client.warnings(far.vehicle, ["fcw", "ima"])
            )
    assert there.receipt.size == 0 or (there.receipt == 0).all()
