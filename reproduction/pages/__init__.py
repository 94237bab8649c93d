"""Pages of a reproduction: Markdown, HTML and figures."""
