"""Whether to believe estimates and which one: for suites, reports and the front door; nothing fits with it."""
