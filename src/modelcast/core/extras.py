"""The optional parts of modelcast: the one table of what each brings and what needs it, and how to get it."""

import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

__all__ = ["EXTRAS", "Extra", "install_command"]


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
            "fleets on simulated radios and platoons that are warned: modelcast network, capacity, mixed, "
            "safety, reproduce --traffic",
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
"""The extras by their names."""


def install_command(requirements: Iterable[str], *, upgrade: bool = False) -> str:
    """Return the command that installs packages for the interpreter that runs this modelcast.

    It names the packages themselves, not an extra of modelcast: no index need have modelcast.

    Parameters
    ----------
    requirements
        Names of packages, or names with the least version.
    upgrade
        Whether they are there, and too old or broken.

    Examples
    --------
    >>> install_command(["lz4", "zstandard>=0.23"]).partition(" install ")[2]
    "lz4 'zstandard>=0.23'"
    """
    interpreter, here = Path(sys.executable), Path.cwd()
    shown = str(interpreter.relative_to(here) if interpreter.is_relative_to(here) else interpreter)
    python = f'"{shown}"' if " " in shown else shown
    installer = f"{python} -m pip install" if find_spec("pip") else f"uv pip install --python {python}"
    wanted = " ".join(one if one.replace("-", "").isalnum() else f"'{one}'" for one in requirements)
    return f"{installer} --upgrade {wanted}" if upgrade else f"{installer} {wanted}"
