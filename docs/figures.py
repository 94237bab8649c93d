"""What sphinx-gallery calls for the figures of examples that pyplot does not hold."""

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

LAST_VALUE = "___"
"""Where sphinx-gallery keeps the value of the last expression of the blocks so far."""


def last_figure(block, block_vars, gallery_conf) -> str:
    """Save the matplotlib figure that is the last value of a block, as `.plot()` gives it; returns its reST."""
    names = block_vars["example_globals"]
    figure = names.get(LAST_VALUE)
    if not isinstance(figure, Figure):
        return ""
    names[LAST_VALUE] = None  # so that the next block does not draw it again
    path = next(block_vars["image_path_iterator"])
    figure.savefig(path, dpi=120)
    return figure_rst([path], gallery_conf["src_dir"])
