"""What a node measures: fixes and values of the vehicle's bus, aligned onto the station's tick.

Three verbs a source, two of the alignment; no iterators that wait::

    source = gnss_source("gpsd://127.0.0.1:2947", now_s=clock.now_s, utc_at_zero_s=clock.minute_utc_s)
    await source.start()                  # connects, and connects again for as long as it runs
    motion = MotionSource(origin)
    every tick:
        motion.feed(source.take(now_s))   # what came since the last call; never waits
        here = motion.at(now_s)           # a Motion for the tick, or None: be silent
        motion.events(), motion.health    # changes of mode, for the log and the page
    await source.stop()

- `start` and `stop` are coroutines of the node's loop. `take` returns at once and may be called from any
  thread. What a source keeps between two calls is bounded: the newest wins, what goes is counted (`counts`).
- Time is the node's: seconds that never fall, 0 at ``utc_at_zero_s``. A sample carries when it was measured
  and when it arrived; nothing before `MotionSource` judges how old is too old.
- `gpsd`, `nmea`, `replay` and `can_bus` are the sources and `opening` makes them from the words of a
  configuration; `samples` says what they give, `signals` what a bus means. `motion_source` aligns by what
  `judging` finds there is, `reckoning` goes on from a fix, `outage` says what the bus is off by, and `frozen`
  finds what stands still and should not.
"""
