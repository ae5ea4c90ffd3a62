"""What is learnt from trips and what the paper claims, with trips in any form."""

from modelcast.interface.given_trips import takes_given_trips
from modelcast.study.paper.run import reproduce_paper as reproduce
from modelcast.study.training.profile import train_profile as train

__all__ = ["reproduce_paper", "train_profile"]

train_profile = takes_given_trips(train)
"""Train everything that vehicles share."""

reproduce_paper = takes_given_trips(reproduce)
"""Run the paper's evaluation over trips under every choice it leaves open, and judge its claims."""
