"""What holds trips below the data folder, one entry a source."""

from pathlib import Path

__all__ = ["folders"]

_KNOWN = ("openacc_zalazone", "spmd/bsm_p1_dev.csv", "comma2k19", "smartloc", "nyc_cvpd")


def folders(data: Path) -> list[Path]:
    """Return files and folders that are there."""
    known = [data / name for name in _KNOWN]
    return [path for path in known if path.exists()] + sorted((data / "roads").glob("*.parquet"))
