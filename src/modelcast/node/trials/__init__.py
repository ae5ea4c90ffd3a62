"""What a node is tried with: drives, a gpsd and a bus that fail as asked, an impaired air, hostile senders.

None of it is part of a node. `drive` says where a vehicle truly is; `gpsd_player` and `bus_player` tell a
node of it; `relay` carries frames between nodes as badly as an `impairment` says; `hostile` makes frames that
no honest station sends. Time is an argument, and everything listens and sends on this machine alone.
"""
