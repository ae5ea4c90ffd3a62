"""The optional parts of modelcast: the one table of what each brings and what needs it."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = ["EXTRAS", "Extra"]


@dataclass(frozen=True, slots=True)
class Extra:
    """An optional part.

    Parameters
    ----------
    packages
        What it installs, by the names to install, with the module of each.
    needed_by
        What cannot be done without it, as words that go on "needed by".
    """

    packages: Mapping[str, str]
    needed_by: str


EXTRAS: Mapping[str, Extra] = MappingProxyType(
    {
        "node": Extra(
            MappingProxyType(
                {
                    "cantools": "cantools",
                    "cryptography": "cryptography",
                    "mcap": "mcap",
                    "msgpack": "msgpack",
                    "pyserial": "serial",
                    "python-can": "can",
                    "starlette": "starlette",
                    "uvicorn": "uvicorn",
                    "websockets": "websockets",
                    "zstandard": "zstandard",
                }
            ),
            "modelcast node, serve, view, replay, demo-live; signing and checking signatures from Python "
            "(modelcast.messages.security)",
        ),
        "network": Extra(
            MappingProxyType({"scipy": "scipy"}),
            "fleets on simulated radios: modelcast network, capacity, mixed, cruise, safety",
        ),
        "train": Extra(
            MappingProxyType({"jax": "jax", "optax": "optax", "scipy": "scipy"}),
            "modelcast train; modelcast compare --bank trained",
        ),
        "etsi": Extra(
            MappingProxyType({"pycrate": "pycrate_asn1rt"}),
            "cooperative awareness messages as octets (modelcast.encode_cam, modelcast.decode_cam)",
        ),
        "mcap": Extra(
            MappingProxyType({"lz4": "lz4", "zstandard": "zstandard"}),
            "trips of MCAP files with packed chunks",
        ),
        "sumo": Extra(
            MappingProxyType({"eclipse-sumo": "sumo", "libsumo": "libsumo"}),
            "modelcast network --scenario sumo-highway, sumo-grid, sumo-junction, FILE.sumocfg",
        ),
        "cluster": Extra(
            MappingProxyType({"cryptography": "cryptography", "distributed": "distributed"}),
            "--cluster: work on several machines",
        ),
    }
)
"""The extras by their names in ``pip install 'modelcast[NAME]'``."""
