"""Import of raw logs: any table with a time and a rudder becomes a record.

`sources` reads files into raw tables (texts or numbers as they stand), `guess` proposes a `mapping` of their columns,
`convert` turns a table into quantities in SI units, `merge` puts several loggers on one time base, `derive` makes the
channels of a record, `segments` cuts it.  `importer` is the chain.
"""
