"""Which numbers of a base model are wrong, by how much: chosen by leaving one record out of free runs."""
