"""Configuration of the documentation site: Sphinx, pages in Markdown (MyST), equations as MathML.

Nothing is loaded from the network, neither while the site is built nor while it is read.
"""

import importlib.metadata
import os
import sys
from functools import partialmethod
from pathlib import Path

from nbclient import NotebookClient

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "helmbench"
author = "the helmbench authors"
copyright = author
release = importlib.metadata.version("helmbench")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_gallery.gen_gallery",
    "docstrings",
    "mathml",
]
exclude_patterns = [
    "_build",
    "jupyter_execute",  # the tutorials as executed
    "gallery",
    "generated/gallery/*.ipynb",
    *(f"generated/indices-{part}.md" for part in ("example", "accuracies", "priors")),
]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
default_role = "code"

nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # the command of this environment
# What a cell prints arrives in pieces that end anywhere: joined as they are.
NotebookClient.__init__ = partialmethod(NotebookClient.__init__, coalesce_streams=True)

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "generated/gallery",
    "backreferences_dir": "generated/examples",
    "doc_module": ("helmbench",),
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("matplotlib", "figures.last_figure"),
    "ignore_repr_types": "matplotlib",
    "run_stale_examples": True,  # the package may have changed where an example has not
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
}

autosummary_generate = True
autosummary_imported_members = True
templates_path = ["_templates"]

autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = "helmbench"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["wide.css"]


def write_generated_pages(app) -> None:
    """Write the pages of tables, equations and pictures from what the installed package holds."""
    import generate

    generate.write(HERE / "generated")
    if app.config.draw_pictures:
        import pictures

        pictures.write(HERE / "generated" / "pictures")


def leave_out_the_tree_of_pages(app, page, _, context, __) -> None:
    """The side bar of every page but the first is empty where it is not asked for: each has the whole tree anew."""
    if not app.config.every_side_bar and page != app.config.root_doc:
        context["toctree"] = lambda **_: ""


def setup(app) -> None:
    app.add_config_value("draw_pictures", True, "env")
    app.add_config_value("every_side_bar", True, "html")
    app.connect("builder-inited", write_generated_pages)
    app.connect("html-page-context", leave_out_the_tree_of_pages, priority=100)
