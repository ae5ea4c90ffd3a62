"""`CITATION.cff` cites what is released, and the paper; other files of the release agree with it."""

import re
import tomllib

import pytest
import yaml

from verify.installing import ROOT, uv

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CHANGES = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_citation_is_of_this_release_and_of_the_paper() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {name: cited[name] for name in ("version", "license", "cff-version")} == {
        "version": PROJECT["version"],
        "license": PROJECT["license"],
        "cff-version": "1.2.0",
    }
    assert f"## {PROJECT['version']} - {cited['date-released']}" in CHANGES
    (paper,) = cited["references"]
    assert [one["family-names"] for one in paper["authors"]] == ["Mahjoub", "Toghi", "Gani", "Fallah"]
    assert paper["doi"].endswith("1903.01576")


def test_what_is_supported_is_what_is_released() -> None:
    text = (ROOT / "SECURITY.md").read_text(encoding="utf-8")
    supported = re.findall(r"(?m)^\| ([\d.]+) \| yes \|$", text)
    assert supported == [PROJECT["version"].rpartition(".")[0]]


def test_no_address_is_named_that_is_not_there() -> None:
    """There is no mailbox; the address of a commit may be nobody's."""
    text = (ROOT / "SECURITY.md").read_text(encoding="utf-8")
    assert not re.search(r"git log|%ae|\w@\w", text)


@pytest.mark.slow
def test_the_citation_is_valid_by_its_schema() -> None:
    tool = ("tool", "run", "--quiet", "--from", "cffconvert==2.0.0", "cffconvert")
    assert "are valid" in uv(*tool, "--validate", "--infile", ROOT / "CITATION.cff")
