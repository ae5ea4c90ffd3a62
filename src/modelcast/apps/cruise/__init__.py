"""Cruise control that listens: what a follower knows of those ahead becomes an acceleration it asks for.

| law | file | keeps | needs |
|---|---|---|---|
| `PathCacc` | `path.py` | a distance | gap; speed and acceleration of the vehicle ahead and of the leader |
| `Ploeg` | `ploeg.py` | a headway | gap; speed and acceleration of the vehicle ahead |
| `Acc` | `acc.py` | a headway | gap and speed of the vehicle ahead: what a ranging sensor shows |

`desired` (`fallback.py`) asks a law where all it needs is known, and `Acc` or nothing where it is not.
"""
