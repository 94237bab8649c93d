"""Page, tables and text of an identification."""
