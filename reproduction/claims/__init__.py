"""The claims of the papers as data, one YAML file a paper, and what reads them."""
