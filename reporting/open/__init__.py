"""What the page of `helmbench open` shows: results as plain values, and the page's own files in `assets`."""
