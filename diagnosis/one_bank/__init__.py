"""One bank of causes, numbers and terms, which compete by free runs of pieces of the records that were left out."""
