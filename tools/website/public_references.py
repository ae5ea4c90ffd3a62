"""A Sphinx extension: names of the public interface lead to where it is described.

Annotations name classes by the module that defines them; the site describes them as ``modelcast.NAME``. Code
in the text that is a public name leads there too.
"""

import re
from collections.abc import Mapping
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform

import modelcast

__all__ = ["setup"]

_HOMES: Mapping[str, str] = modelcast.__dict__["_HOMES"]
_IN_TEXT = re.compile(r"(?:modelcast\.)?(\w+)((?:\.\w+)?)(?:\(\))?")


def _public(target: str) -> str | None:
    """The public address of an address inside the package; None where it has none."""
    module, _, rest = target.removeprefix("modelcast.").rpartition(".")
    above, _, owner = module.rpartition(".")
    for home, name in ((module, rest), (above, f"{owner}.{rest}")):
        if _HOMES.get(name.partition(".")[0]) == home:
            return f"modelcast.{name}"
    return None


def _resolve(
    app: Sphinx, env: BuildEnvironment, node: addnodes.pending_xref, contnode: nodes.TextElement
) -> nodes.reference | None:
    """The reference of an address inside the package."""
    target = str(node.get("reftarget", ""))
    public = _public(target) if node.get("refdomain") == "py" and target.startswith("modelcast.") else None
    if public is None:
        return None
    domain = env.domains["py"]
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", public, node, contnode)


class NamesInText(SphinxPostTransform):
    """Code that is a public name, in a page's text, becomes a reference."""

    default_priority = 5

    def run(self, **_: Any) -> None:
        """Replace them."""
        for literal in list(self.document.findall(nodes.literal)):
            found = _IN_TEXT.fullmatch(literal.astext())
            if (
                found is None
                or found[1] not in _HOMES
                or isinstance(literal.parent, nodes.reference | addnodes.pending_xref)
            ):
                continue
            # Commands have the names of functions: a lone word in small letters may be either.
            if literal.astext() == found[1] and found[1].islower() and "_" not in found[1]:
                continue
            reference = addnodes.pending_xref(
                "",
                refdomain="py",
                reftype="obj",
                reftarget=f"modelcast.{found[1]}{found[2]}",
                refdoc=self.env.docname,
                refexplicit=False,
                refwarn=False,
            )
            literal.replace_self(reference)
            reference += literal


def setup(app: Sphinx) -> dict[str, bool]:
    """Take part in a build."""
    app.connect("missing-reference", _resolve)
    app.add_post_transform(NamesInText)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
