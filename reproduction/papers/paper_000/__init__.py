"""Paper 000: FW-RLS on the K-T equation of the REMUS vehicle."""
