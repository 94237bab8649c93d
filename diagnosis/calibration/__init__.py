"""Which numbers of a base model are wrong, by how much: the answer of a diagnosis, told number by number."""
