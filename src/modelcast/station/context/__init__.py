"""What a sender knows beside its own motion: the road as driven before, and the vehicle ahead.

`modelcast.models.context_columns` says in which columns of a sample it stands. The road comes from a memory
of earlier drives (`road`), the vehicle ahead from the sender's own local dynamic map (`ahead_kernels`).
"""
