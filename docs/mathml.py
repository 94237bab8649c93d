"""Sphinx extension: equations as MathML, which browsers draw themselves, in place of a script from the network."""

from html import escape

from docutils import nodes
from latex2mathml.converter import convert


def visit_math(translator, node: nodes.math) -> None:
    translator.body.append(convert(node.astext(), display="inline"))
    raise nodes.SkipNode


def visit_math_block(translator, node: nodes.math_block) -> None:
    label = node.get("label")
    identifier = f' id="equation-{escape(label)}"' if label else ""
    translator.body.append(f'<div class="math"{identifier}>{convert(node.astext(), display="block")}</div>\n')
    raise nodes.SkipNode


def setup(app) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_math_block, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
