"""What Foxglove draws by itself: ``foxglove.LocationFix`` and ``foxglove.GeoJSON``."""

import json
import math
from typing import Any

from modelcast.core.geodesy import Origin, local_to_geodetic
from modelcast.node.inputs.motion import Motion
from modelcast.node.recording.plain import word_of
from modelcast.station.receiver.local_dynamic_map import Beliefs

__all__ = ["geojson_words", "location_words"]


def location_words(motion: Motion, t_ns: int) -> dict[str, Any]:
    """The own place, as ``foxglove.LocationFix``.

    Parameters
    ----------
    motion
        The own motion.
    t_ns
        Since 1970 [ns].
    """
    (east, both), (_, north) = motion.covariance_m2.tolist()
    seconds, rest = divmod(t_ns, 1_000_000_000)
    return {
        "timestamp": {"sec": seconds, "nsec": rest},
        "frame_id": "vehicle",
        "latitude": motion.place_deg[0],
        "longitude": motion.place_deg[1],
        "altitude": motion.altitude_m if math.isfinite(motion.altitude_m) else 0.0,
        "position_covariance": [east, both, 0.0, both, north, 0.0, 0.0, 0.0, 0.0],
        "position_covariance_type": 3 if motion.ellipse_known else 1,
    }


def geojson_words(around: Beliefs, origin: Origin) -> dict[str, Any]:
    """Where remotes are believed to be, as ``foxglove.GeoJSON``; one that is nowhere on Earth is left out."""
    places_deg = local_to_geodetic(around.position_m, origin).tolist()
    features = [
        {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [longitude, latitude]},
            "properties": {"name": str(vehicle), "speed_mps": word_of(speed), "age_s": word_of(age)},
        }
        for vehicle, (latitude, longitude), speed, age in zip(
            around.vehicle.tolist(),
            places_deg,
            around.speed_mps.tolist(),
            around.information_age_s.tolist(),
            strict=True,
        )
        if math.isfinite(latitude + longitude)
    ]
    return {"geojson": json.dumps({"type": "FeatureCollection", "features": features}, separators=(",", ":"))}
