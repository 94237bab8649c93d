"""What methods and diagnosis fit with, sorted by who uses it; a folder imports only those named before it.

numerics, records, observers, simulation, regression, results, likelihood, filters : for both.
diagnosis_only : for diagnosis alone.
information, estimates : what records tell of a model's numbers, and the result of a fit, which says so.
validation : free runs held against records, for diagnosis and suites.
methods_only : for methods alone; suites and papers ask what they say of themselves.
judgement, indices : for suites, reports and the front door.
"""
