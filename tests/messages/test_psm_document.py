"""Claims about personal safety messages as plain documents: nothing is lost, and what is wrong is told."""

import json
from typing import Any

import pytest
from hypothesis import given, settings

from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, person_codes
from modelcast.messages.psm_document import person_document, person_of

from .people import messages

CODES = person_codes({"basic_type": 2, "message_count": 7, "temporary_id": 1, "speed_mps": 4.2})
PLAIN = PersonalSafetyMessage(CODES)
HISTORY = (None, None, ((100, -100, 0, 250, 70, None, 60), (-131072, 5, -2048, 65535, None, (1, 2, 3), 240)))


@given(messages())
@settings(max_examples=200)
def test_the_message_of_a_document_of_a_message_is_that_message(message: PersonalSafetyMessage) -> None:
    assert person_of(json.loads(json.dumps(person_document(message)))) == message


def test_a_document_has_si_units_names_and_nulls() -> None:
    message = PersonalSafetyMessage(
        CODES,
        path_prediction=(-123, 100),
        parts=(
            ("path_history", HISTORY),
            ("propulsion", (2, 3)),
            ("use_state", 0b000001000),
            ("cross_state", 1),
            ("attachment_radius_m", 15),
        ),
    )
    document = person_document(message)
    assert document["message"] == "psm"
    assert document["basic_type"] == "aPEDALCYCLIST"
    assert document["message_count"] == 7
    assert document["temporary_id"] == "00000001"
    assert document["speed_mps"] == 4.2
    assert document["elevation_m"] is document["latitude_deg"] is None
    assert document["path_prediction"] == {"path_radius_m": -12.3, "path_confidence_ratio": 0.5}
    assert document["propulsion"] == {"motor": "bicycle"}
    assert document["use_state"] == ["calling"]
    assert document["cross_state"] is True
    assert document["attachment_radius_m"] == 1.5
    first, second = document["path_history"]["crumbs"]
    assert first["latitude_offset_deg"] == pytest.approx(1e-5)
    assert first["age_s"] == 2.5
    assert first["heading_rad"] == pytest.approx(1.5707963)
    assert "accuracy" not in first
    assert second["latitude_offset_deg"] is second["age_s"] is second["heading_rad"] is None
    assert "initial_position" not in document["path_history"]


def test_an_elevation_that_is_left_out_is_not_one_that_is_unknown() -> None:
    document = person_document(PLAIN)
    assert document.pop("elevation_m", 0.0) is None
    assert person_of(document) == PersonalSafetyMessage(CODES, has_elevation=False)
    assert "elevation_m" not in person_document(PersonalSafetyMessage(CODES, has_elevation=False))


def test_a_published_message_says_what_its_sender_is() -> None:
    octets = bytes.fromhex("00201a0000021bd86891de75f84da101c13f042e2214141fff00022c20")
    document = person_document(decode_psm(octets))
    assert document["basic_type"] == "aPEDESTRIAN"
    assert document["latitude_deg"] == 40.2397377


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"speed": 1}, "no field is called speed"),
        ({"transmission": "park"}, "no field is called transmission"),
        ({"message": "bsm"}, "message must be 'psm'"),
        ({"message_count": None, "temporary_id": None}, "message_count and temporary_id must be given"),
        ({"basic_type": "pedestrian"}, "basic_type must be one of unavailable, aPEDESTRIAN"),
        ({"basic_type": {"code": 5}}, "within 0..4"),
        ({"speed_mps": "fast"}, "number or null"),
        ({"cross_state": 1}, "cross_state must be true or false"),
        ({"cross_state": None}, "cross_state must be true or false"),
        ({"sizing": "small_stature"}, "sizing must be a list"),
        ({"sizing": ["small"]}, "sizing may hold unavailable, small_stature"),
        ({"propulsion": "bicycle"}, "propulsion must be an object of one of human, animal, motor"),
        ({"propulsion": {"motor": "bicycle", "human": "onFoot"}}, "propulsion must be an object of one"),
        ({"propulsion": {"jet": "bicycle"}}, "propulsion must be an object of one"),
        ({"propulsion": {"motor": "car"}}, "motor must be one of unavailable, otherTypes"),
        ({"acceleration": 3}, "acceleration must be an object"),
        ({"acceleration": {"forward": 3}}, "acceleration has no forward; it has acceleration_forward_mps2"),
        ({"acceleration": {}}, "yaw_rate_radps"),
        ({"path_history": {}}, "crumbs must be a list"),
        ({"path_history": {"crumbs": []}}, "crumbs must be 1 to 23"),
        ({"path_history": {"crumbs": [{"age": 1}]}}, "crumb has no age"),
        ({"path_history": {"crumbs": [{}] * 24}}, "crumbs must be 1 to 23"),
        ({"regional": [{"id": 1}]}, "id and octets"),
        ({"frame_additions": ["zz"]}, "hexadecimal"),
    ],
)
def test_a_document_that_is_wrong_is_a_value_error(change: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        person_of(person_document(PLAIN) | change)


@pytest.mark.parametrize("document", [[], 7, "psm", None])
def test_a_document_is_an_object(document: object) -> None:
    with pytest.raises(ValueError, match="an object with fields"):
        person_of(document)
