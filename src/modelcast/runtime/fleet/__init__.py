"""The closed loop: traffic moves, senders decide, messages contend, receivers track.

`engine.run_network` is the loop; `sender.FleetSender` says what is sent when; `arrays` holds what the fleet
knows. It runs over any iterable of `modelcast.world.scenario.base.FleetFrame` and any radio.
"""
