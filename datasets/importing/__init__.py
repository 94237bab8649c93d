"""Import of raw logs: any table with a time and a rudder becomes a record.

`sources` reads files into raw tables (texts or numbers as they stand), `guess` proposes a `mapping` of their columns,
`convert` turns a table into quantities in SI units and these into channels of a record, `merge` puts several loggers on
one time base, `segments` cuts a record.  `importer` is the chain.
"""
