"""Traffic: fleets of vehicles on roads, one frame every 0.1 s.

`highway` and `grid` are built in and need nothing installed; `replay` and `library` take recorded trips;
`sensed` puts a receiver and a vehicle bus between a frame and what its vehicles see. Files and SUMO are in
`modelcast.io.fcd` and `modelcast.io.sumo`, which yield the same frames.
"""
