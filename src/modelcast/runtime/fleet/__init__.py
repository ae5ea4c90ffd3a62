"""The closed loop: traffic moves, senders decide, messages contend, receivers track.

`engine.run_network` is a run, `loop.FleetLoop` one step of it; `arrays` holds what the hosts track and count.
What is sent when is the stations' affair (`modelcast.station.sender`). A run takes any iterable of
`modelcast.world.scenario.base.FleetFrame` and any radio.
"""
