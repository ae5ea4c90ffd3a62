"""Signed messages of IEEE 1609.2: who sent it, when, and that it is unchanged.

`certificate` and `signed` are values and octets, read without any library. `p256` alone imports the
``cryptography`` package (the extra ``node``); `authority`, `signer` and `verifier` stand on it.
``docs/security.md`` says which parts of the standard are left out, ``docs/wire.md`` tells the octets.
"""
