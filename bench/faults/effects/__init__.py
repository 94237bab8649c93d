"""Effects that the truth simulator injects, found by the registry (`base.kinds`): files by where they act."""
